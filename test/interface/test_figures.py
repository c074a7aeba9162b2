"""Figures for /diagnostics."""

from dataclasses import dataclass, replace

from interface.test_health import SETTINGS, estimate, statuses

from obs_ros.core.estimate import Jump
from obs_ros.interface import figures as shown
from obs_ros.interface.health import examine
from obs_ros.interface.progress import Progress


def test_figures_are_there_from_the_start():
    figures = examine(Progress(), statuses(output=None), SETTINGS, {}, None).figures
    assert figures == {
        'outcome': 'compiling',
        'observer': 'sliding_window',
        'ready': False,
        'compiled': False,
        'enabled': True,
        'solving': False,
        'published': 0,
        'withheld': 0,
        'failed': 0,
        'jumps': 0,
        'compile_time_s': 0.0,
        'output.received': 4,
        'output.rate_hz': 2.5,
        'output.publishers': 1,
        'output.reliable': True,
        'output.lost': 0,
        'input.received': 4,
        'input.rate_hz': 2.5,
        'input.publishers': 1,
        'input.reliable': True,
        'input.lost': 0,
        'skipped': 0,
    }


def test_figures_of_the_solver_of_refusals_and_of_the_window():
    progress = Progress(ready=True, compile_time=1.5)
    progress.conclude(estimate(), latency=0.2, published=True)
    refusal = 'plant/output: 2 names but 1 positions'
    streams = statuses(refused={'wrong_length': 2}, last_refusal=refusal)
    figures = examine(progress, streams, SETTINGS, {'late': 3, 'skipped': 6}, 'back to 1').figures
    expected = {
        'residual_rms': 0.1,
        'evaluations': 7,
        'solve_time_s': 0.01,
        'latency_s': 0.2,
        'compile_time_s': 1.5,
        'output.wrong_length': 2,
        'output.last_refusal': 'plant/output: 2 names but 1 positions',
        'samples.late': 3,
        'skipped': 6,
        'last_break': 'back to 1',
    }
    assert {name: figures[name] for name in expected} == expected
    assert not {'samples.skipped', 'input.last_refusal'} & set(figures)


def test_predictions_have_figures_and_so_has_a_cache_that_fails(monkeypatch):
    @dataclass
    class FakeForecast:
        published: int = 7
        diverged: int = 1
        horizon: float | None = 2.5
        latency: float = 0.25

    def seen(forecast):
        return examine(Progress(), statuses(), SETTINGS, {}, None, forecast).figures

    figures = seen(FakeForecast())
    assert (figures['predicted'], figures['prediction_diverged']) == (7, 1)
    assert (figures['prediction_horizon_s'], figures['prediction_latency_s']) == (2.5, 0.25)
    assert 'prediction_horizon_s' not in seen(FakeForecast(horizon=None))
    assert 'predicted' not in seen(None) and 'kernel_cache' not in seen(None)
    monkeypatch.setattr(shown, 'cache_trouble', lambda: 'disk full')
    assert seen(None)['kernel_cache'] == 'disk full'


def seen_with(progress):
    return examine(progress, statuses(), SETTINGS, {}, None).figures


JUMP = Jump(5.0, 0.1, {'p': -0.3}, {'p': 0.01}, new=True, probability=0.97, alternatives=('q',))


def test_the_last_jump_has_its_deviation_its_probability_and_its_rivals():
    progress = Progress(ready=True)
    progress.conclude(replace(estimate(), jumps=(JUMP,)), 0.1, published=True)
    figures = seen_with(progress)
    assert figures['jumps'] == 1 and figures['last_jump.or'] == 'q'
    assert figures['last_jump'] == 'jump at 5.00 s +- 0.2 s: p -0.3 +- 0.02, probability 0.97'
    assert figures['last_jump.probability'] == 0.97
    assert not {'retractions', 'last_retraction', 'drifting'} & set(figures)
    unknown = replace(estimate(), jumps=(replace(JUMP, probability=float('nan')),))
    progress.conclude(unknown, 0.1, published=True)
    assert 'last_jump.probability' not in seen_with(progress)


def test_a_jump_that_is_taken_back_is_the_last_one_no_more():
    progress = Progress(ready=True)
    refined = replace(JUMP, time=5.2, new=False)  # as a later window says
    back = replace(JUMP, sizes={'p': 0.0}, stddev={'p': 0.0}, retracted=True)
    for jumps in ((JUMP,), (refined,), (back,)):
        progress.conclude(replace(estimate(), jumps=jumps), 0.1, published=True)
    figures = seen_with(progress)
    assert (figures['jumps'], figures['retractions']) == (1, 1)
    assert figures['last_retraction'] == 'jump at 5.00 s taken back: p'
    assert not any(name.startswith('last_jump') for name in figures)


def test_another_jump_stays_when_one_is_taken_back():
    progress = Progress(ready=True)
    other = replace(JUMP, time=9.0)
    back = replace(JUMP, sizes={'p': 0.0}, stddev={'p': 0.0}, retracted=True)
    for jumps in ((JUMP,), (other, back)):
        progress.conclude(replace(estimate(), jumps=jumps), 0.1, published=True)
    figures = seen_with(progress)
    assert (figures['jumps'], figures['retractions']) == (2, 1)
    assert figures['last_jump'].startswith('jump at 9.00 s')


def test_a_parameter_that_drifts_is_told_with_its_remedy():
    progress = Progress(ready=True)
    progress.conclude(replace(estimate(), drifting=('p',)), 0.1, published=True)
    assert seen_with(progress)['drifting'].startswith('give it a walk: walk.p')
