"""Figures for /diagnostics."""

from dataclasses import dataclass

from interface.test_health import SETTINGS, estimate, statuses

from obs_ros.interface import figures as shown
from obs_ros.interface.health import examine
from obs_ros.interface.progress import Progress


def test_figures_are_there_from_the_start():
    figures = examine(Progress(), statuses(output=None), SETTINGS, {}, None).figures
    assert figures == {
        'outcome': 'compiling',
        'observer': 'sliding_window',
        'ready': False,
        'enabled': True,
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
