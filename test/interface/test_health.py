from dataclasses import replace

import pytest

from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.interface.health import examine, not_configured
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import Level, SubscriptionStatus

SETTINGS = {
    'observer': 'sliding_window',
    'stale_after': 5.0,
    'seed': 3,
    'window.duration': 1000.0,
}


def statuses(output=0.1, input=0.1, **changes):
    """Status of both streams, silent for so many s; `changes` are of the output's."""
    usual = {'received': 4, 'rate': 2.5}
    return {
        'output': SubscriptionStatus('plant/output', 'output', output, **(usual | changes)),
        'input': SubscriptionStatus('plant/input', 'input', input, **usual),
    }


def estimate(outcome=Outcome.CONVERGED, value=1.0):
    return Estimate(
        parameters={'p': value}, initial_state={}, state={}, stddev={}, outcome=outcome,
        message='as told', t0=0.0, t1=1.0, residual_rms=0.1, evaluations=7, solve_time=0.01,
    )  # fmt: skip


def judged(progress=None, streams=None, counts=None, **changes):
    """Level, outcome and message of a ready estimator with an estimate, and what differs."""
    progress = progress or Progress(**({'ready': True, 'estimate': estimate()} | changes))
    health = examine(progress, streams or statuses(), SETTINGS, counts or {}, None)
    return health.level, health.figures['outcome'], health.message


def test_all_is_well():
    assert judged() == (Level.OK, 'converged', 'converged: as told')


@pytest.mark.parametrize(
    ('changes', 'expected'),
    [
        (
            {'active': False},
            (Level.WARN, 'inactive', 'inactive: call change_state with activate to go on'),
        ),
        (
            {'active': False, 'ready': False},
            (
                Level.WARN,
                'inactive',
                'inactive: call change_state with activate to go on; compiling the model',
            ),
        ),
        (
            {'active': False, 'error': 'no'},
            (Level.ERROR, 'inactive', 'inactive; the observer failed: no'),
        ),
        ({'enabled': False}, (Level.WARN, 'paused', 'paused: call ~/enable with true to go on')),
        (
            {'error': 'ValueError: no'},
            (Level.ERROR, 'failed', 'the observer failed: ValueError: no'),
        ),
        (
            {'ready': False},
            (
                Level.WARN,
                'compiling',
                'compiling the model; the first time it takes several seconds',
            ),
        ),
        (
            {'estimate': None},
            (
                Level.OK,
                'collecting',
                'collecting the first window: 0 of 1000 s; '
                'waiting for an output with every input known',
            ),
        ),
        (
            {'estimate': None, 'collected': 140.2},
            (Level.OK, 'collecting', 'collecting the first window: 140 of 1000 s'),
        ),
        ({'estimate': None, 'solving': True}, (Level.OK, 'collecting', 'solving the first window')),
    ],
)
def test_what_the_estimator_is_doing(changes, expected):
    assert judged(**changes) == expected


@pytest.mark.parametrize('outcome', Outcome)
def test_every_outcome_has_a_level_and_keeps_its_message(outcome):
    fine = (Outcome.CONVERGED, Outcome.AT_BOUND, Outcome.APPROXIMATE)
    level = Level.OK if outcome in fine else Level.WARN
    level = Level.ERROR if outcome is Outcome.DIVERGED else level
    assert judged(estimate=estimate(outcome)) == (level, outcome.value, f'{outcome.value}: as told')


def test_an_estimate_that_is_not_finite_is_said_to_be_withheld():
    assert judged(estimate=estimate(Outcome.TOO_FEW_SAMPLES, float('nan'))) == (
        Level.WARN, 'too_few_samples', 'too_few_samples (withheld: not finite): as told'
    )  # fmt: skip


@pytest.mark.parametrize('name', ['output', 'input'])
def test_a_stream_that_never_came_is_waited_for(name):
    streams = statuses(**{name: None})
    assert judged(streams=streams) == (
        Level.WARN, 'waiting', f'waiting for plant/{name}: its publisher has sent nothing yet'
    )  # fmt: skip
    streams[name] = replace(streams[name], publishers=0)
    assert judged(streams=streams)[2] == (
        f'waiting for plant/{name}: start its publisher, or look at the name: nobody publishes it'
    )
    refusal = f"plant/{name}: 'h1' is missing"
    streams[name] = replace(streams[name], last_refusal=refusal)
    assert judged(streams=streams)[2] == (
        f"waiting for plant/{name}: its messages are refused: plant/{name}: 'h1' is missing"
    )


@pytest.mark.parametrize('name', ['output', 'input'])
def test_a_stream_that_fell_silent_is_stale(name):
    outcome = f'stale_{name}'
    assert judged(streams=statuses(**{name: 5.1})) == (
        Level.STALE, outcome, f'{outcome}: does a publisher run? no plant/{name} for more than 5 s'
    )  # fmt: skip
    assert judged(streams=statuses(**{name: 5.0}))[0] is Level.OK


def test_what_keeps_estimates_from_coming_stands_first():
    state = {'enabled': False, 'error': 'E: no', 'ready': False, 'estimate': None}
    streams = statuses(output=None, input=99.0)
    seen = [judged(streams=streams, **state)[1]]
    for cured in ({'enabled': True}, {'error': ''}, {'ready': True}):
        state |= cured
        seen.append(judged(streams=streams, **state)[1])
    for silence in ({'output': 99.0, 'input': 99.0}, {'input': 99.0}, {}):
        seen.append(judged(streams=statuses(**silence), **state)[1])
    seen.append(judged(**(state | {'estimate': estimate()}))[1])
    assert seen == [
        'paused', 'failed', 'compiling', 'waiting', 'stale_output', 'stale_input', 'collecting',
        'converged',
    ]  # fmt: skip


@pytest.mark.parametrize(
    ('counts', 'message'),
    [
        ({'overflow': 1}, 'shorten window.duration, or raise window.capacity: '
         'a window of 1000 s holds more samples than that'),
        ({'duplicate': 4}, 'let the publisher set header.stamp: stamps do not advance'),
        ({'off_grid': 4}, "look at stamps and rates: most samples lie between the nodes of the "
         "model's period, where outputs do not count"),
        ({'all_nan': 4}, 'look at what is measured: the samples hold no numbers, '
         'only NaN or infinity'),
    ],
)  # fmt: skip
def test_what_keeps_the_first_window_from_closing_is_said(counts, message):
    assert judged(estimate=None, counts=counts) == (Level.WARN, 'collecting', message)
    assert judged(counts=counts)[0] == Level.OK, 'with an estimate it is only a count'
    few = dict.fromkeys(set(counts) - {'overflow'}, 1)
    assert judged(estimate=None, counts=few)[0] == Level.OK


def test_refused_messages_are_not_taken_for_silence():
    streams = statuses(output=6.0, refuses=True, last_refusal="unknown name 'theta'")
    level, outcome, message = judged(streams=streams)
    assert (level, outcome) == (Level.STALE, 'stale_output')
    assert message == "stale_output: its messages are refused: unknown name 'theta'"


def test_publishers_that_take_turns_are_told_before_the_outcome():
    level, outcome, message = judged(streams=statuses(alternating=True, publishers=2))
    assert (level, outcome) == (Level.WARN, 'mixed')
    assert message.startswith('mixed: stop all but one of the 2 publishers of plant/output')


@pytest.mark.parametrize('silence', [None, 9.0])
def test_a_publisher_that_is_not_heard_is_the_reason_of_silence(silence):
    unheard = 'a publisher of plant/output is not heard: why'
    message = judged(streams=statuses(silence, unheard=unheard))[2]
    assert message.endswith(f': {unheard}')
    assert judged(streams=statuses(unheard=unheard))[0] is Level.OK


@pytest.mark.parametrize('ahead', [1500, -1500])
def test_streams_stamped_by_two_clocks_are_told(ahead):
    level, _, message = judged(estimate=None, streams=stamped(2000, 2000 + ahead))
    assert level is Level.WARN
    last, first = ('input', 'output') if ahead > 0 else ('output', 'input')
    assert message == (
        f'use one clock for both publishers: plant/{last} is stamped 1500 s after plant/{first}'
    )
    level, _, message = judged(estimate=None, collected=99.0, streams=stamped(2000, 2900))
    assert level is Level.OK
    assert message.endswith('99 of 1000 s; plant/output is 900 s behind plant/input')


def test_a_backlog_is_said_to_be_one_and_not_a_silent_publisher():
    """Messages that wait unread make the other streams look silent."""
    level, outcome, message = judged(behind=3.21, streams=statuses(input=6.0))
    assert (level, outcome) == (Level.WARN, 'behind')
    assert message.startswith('3.2 s behind: this machine is too slow for observer sliding_window')
    assert judged(behind=0.99)[1] == 'converged'
    silent = judged(behind=3.21, streams=statuses(input=6.0, output=6.0))
    assert silent[1] == 'stale_output', 'once nothing comes any more'


def test_samples_that_come_late_are_a_warning_for_some_time():
    progress = Progress(ready=True, estimate=estimate())
    progress.begin_examination(0)
    assert judged(progress)[0] is Level.OK
    progress.begin_examination(7)
    level, outcome, message = judged(progress)
    assert (level, outcome) == (Level.WARN, 'converged')
    assert message.startswith('raise merge_wait: 7 samples came late') and 'as told' in message
    for _ in range(progress.late_for):
        assert judged(progress)[0] is Level.WARN
        progress.begin_examination(7)
    assert judged(progress)[0] is Level.OK


def test_a_checkpoint_that_cannot_be_written_is_a_warning_beside_the_estimate():
    progress = Progress(ready=True, estimate=estimate())
    progress.unsaved, progress.checkpoint = 'look at the disk', {'checkpoint.failed': 2}
    level, outcome, message = judged(progress)
    assert (level, outcome) == (Level.WARN, 'converged')
    assert message.startswith('look at the disk; converged') and 'as told' in message
    progress.begin_examination(0)
    progress.begin_examination(7)
    assert judged(progress)[2].startswith('raise merge_wait: 7 samples came late just now; look at')
    progress.unsaved = ''
    assert 'disk' not in judged(progress)[2]


SEEN = 128  # characters that `ros2 topic echo` shows


def stamped(output, input):
    """Status of both streams, their newest stamps (s) at these times."""
    streams = statuses(stamp=output * 10**9)
    return streams | {'input': replace(streams['input'], stamp=input * 10**9)}


REFUSAL = "plant/output: unknown name 'theta': did you mean 'th'?" + 500 * 'x'
REMEDIES = {
    'paused': ({'enabled': False}, {}, '~/enable'),
    'nobody': ({}, {'streams': statuses(output=None, publishers=0)}, 'start its publisher'),
    'silent': ({}, {'streams': statuses(output=None)}, 'waiting for plant/output'),
    'refused': ({}, {'streams': statuses(output=None, last_refusal=REFUSAL)}, "did you mean 'th'"),
    'refused again': (
        {}, {'streams': statuses(9.0, refuses=True, last_refusal=REFUSAL)}, "did you mean 'th'"
    ),
    'unheard': ({}, {'streams': statuses(output=9.0, unheard='its QoS x is another')}, 'its QoS x'),
    'behind': ({'behind': 9.9}, {}, 'publish less often, or'),
    'stale': ({}, {'streams': statuses(output=9.0)}, 'does a publisher run?'),
    'mixed': ({}, {'streams': statuses(alternating=True, publishers=2)}, 'stop all but one'),
    'clocks': ({'estimate': None}, {'streams': stamped(0, 5000)}, 'use one clock'),
    'overflow': ({'estimate': None}, {'counts': {'overflow': 1}}, 'shorten window.duration'),
    'duplicate': ({'estimate': None}, {'counts': {'duplicate': 9}}, 'set header.stamp'),
    'all_nan': ({'estimate': None}, {'counts': {'all_nan': 9}}, 'look at what is measured'),
    'collecting': ({'estimate': None, 'collected': 1.0}, {}, 'collecting the first window: 1 of'),
}  # fmt: skip


@pytest.mark.parametrize('case', REMEDIES)
def test_what_to_do_stands_in_what_the_command_shows(case):
    changes, given, remedy = REMEDIES[case]
    assert remedy in judged(**changes, **given)[2][:SEEN]


@pytest.mark.parametrize(
    ('state', 'trouble', 'level', 'message'),
    [
        ('unconfigured', '', Level.WARN, 'call change_state with configure to go on'),
        ('unconfigured', 'no model', Level.ERROR, 'no model'),
        ('finalized', '', Level.WARN, 'start it anew to go on'),
    ],
)
def test_a_managed_node_that_is_not_configured_says_what_to_do(state, trouble, level, message):
    health = not_configured(state, trouble)
    assert (health.level, health.message) == (level, f'{state}: {message}')
    assert health.figures == {'outcome': state}
