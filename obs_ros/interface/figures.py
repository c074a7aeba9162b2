"""Figures of an estimator for /diagnostics, by name."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from obs_ros.core.drifting import remedy
from obs_ros.core.kernel_cache import cache_trouble
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import SubscriptionStatus

Figure = tuple[str, object]


def figures(
    progress: Progress,
    subscriptions: Mapping[str, SubscriptionStatus],
    settings: Mapping[str, Any],
    counts: Mapping[str, int],
    last_break: str | None,
    forecast: Forecast | None,
) -> Iterator[Figure]:
    """Yield every figure that is known, in the order in which they are shown."""
    yield 'observer', settings['observer']
    yield from _of_progress(progress)
    for name, status in subscriptions.items():
        yield from _of_subscription(name, status)
    yield from ((f'samples.{reason}', n) for reason, n in counts.items() if reason != 'skipped')
    yield 'skipped', counts.get('skipped', 0)
    if forecast is not None:
        yield from _of_forecast(forecast)
    if trouble := cache_trouble():
        yield 'kernel_cache', trouble
    if last_break:
        yield 'last_break', last_break


def _of_progress(progress: Progress) -> Iterator[Figure]:
    yield 'ready', progress.ready
    yield 'compiled', progress.compiled
    yield 'enabled', progress.enabled
    yield 'solving', progress.solving
    yield 'published', progress.published
    yield 'withheld', progress.withheld
    yield 'failed', progress.failed
    yield 'compile_time_s', progress.compile_time
    if progress.too_early:
        yield 'too_early', progress.too_early
    if estimate := progress.estimate:
        yield 'residual_rms', estimate.residual_rms
        yield 'evaluations', estimate.evaluations
        yield 'solve_time_s', estimate.solve_time
        yield 'latency_s', progress.latency
        yield 'behind_s', progress.behind
        yield from ((f'residual_rms.{name}', rms) for name, rms in estimate.output_rms.items())
        yield from estimate.figures.items()
        yield from ((f'weak.{i}', words) for i, words in enumerate(estimate.weak, 1))
        if estimate.advice:
            yield 'advice', estimate.advice
        if estimate.drifting:
            yield 'drifting', remedy(estimate.drifting)
    if progress.outlier:
        yield 'last_outlier', progress.outlier
    yield from _of_jumps(progress)
    yield from progress.checkpoint.items()


def _of_jumps(progress: Progress) -> Iterator[Figure]:
    yield 'jumps', progress.jumps
    if jump := progress.jump:
        yield 'last_jump', str(jump)
        if not math.isnan(jump.probability):
            yield 'last_jump.probability', jump.probability
        if jump.alternatives:
            yield 'last_jump.or', '; '.join(jump.alternatives)
    if progress.retraction:
        yield 'retractions', progress.retractions
        yield 'last_retraction', str(progress.retraction)


def _of_subscription(name: str, status: SubscriptionStatus) -> Iterator[Figure]:
    yield f'{name}.received', status.received
    yield f'{name}.rate_hz', status.rate
    yield f'{name}.publishers', status.publishers
    yield f'{name}.reliable', status.reliable
    yield f'{name}.lost', status.lost
    yield from ((f'{name}.{reason}', count) for reason, count in status.refused.items())
    if status.other_names:
        yield f'{name}.other_names', status.other_names
    if status.last_refusal:
        yield f'{name}.last_refusal', status.last_refusal


def _of_forecast(forecast: Forecast) -> Iterator[Figure]:
    yield 'predicted', forecast.published
    yield 'prediction_diverged', forecast.diverged
    if forecast.horizon is not None:
        yield 'prediction_horizon_s', forecast.horizon
        yield 'prediction_latency_s', forecast.latency
