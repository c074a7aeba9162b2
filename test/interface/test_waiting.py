from obs_ros.interface.status import Health, Level
from obs_ros.interface.waiting import Waiting


def health(outcome, level=Level.OK, message=''):
    return Health(level, message or outcome, {'outcome': outcome})


def test_waiting_is_told_at_once_and_then_ever_more_rarely():
    waiting = Waiting()
    lines = [waiting.line(health('collecting', message=f'{k} of 100 s')) for k in range(100)]
    assert [line for line in lines if line] == [f'{k} of 100 s' for k in (0, 10, 20, 40, 80)]


def test_another_reason_is_told_at_once():
    waiting = Waiting()
    seen = [
        waiting.line(each)
        for each in (
            health('compiling'), health('waiting', Level.WARN), health('waiting', Level.WARN),
            health('collecting'), health('collecting', Level.WARN, 'clocks'), health('converged'),
            health('stale_input', Level.STALE), health('converged'),
            health('stale_input', Level.STALE),
        )
    ]  # fmt: skip
    assert seen == ['', 'waiting', '', 'collecting', 'clocks', '', 'stale_input', '', 'stale_input']
