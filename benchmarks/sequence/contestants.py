"""Ways to estimate a run window by window: ours, and other uses of earlier windows."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.sequence.plants import Run
from obs_ros import Estimate, Record, Sample, load_observer
from obs_ros.core.deadline import Deadline
from obs_ros.core.model import names
from obs_ros.core.rng import random_generator
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.assemble import report
from obs_ros.inference.assessment.informed_subspace import marginal_information
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.jumps.hypothesis import Hypothesis, hypothesis_at
from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.jumps.settings import JUMP_SETTINGS
from obs_ros.inference.prior import Prior
from obs_ros.observers.base import OBSERVERS

TIKHONOV = 0.02  # box, standard deviation about the previous estimate
NANOSECONDS = 1e9


def given_noise(run: Run, factor: float = 1.0) -> Mapping[str, float]:
    """Return the noise of every output, or a wrong one."""
    return dict.fromkeys(names(run.plant.model.outputs), factor * run.sigma)


def ours(
    run: Run, period: float, factor: float | None = None, learn_noise: bool = False
) -> list[Estimate]:
    """Solve as `SlidingWindowObserver` does; noise times `factor` is given, or none."""
    noise = None if factor is None else given_noise(run, factor)
    windows = MovingHorizon(
        Solver.of(run.plant.model, EstimationSettings(noise=noise)), learn_noise=learn_noise
    )
    return [
        windows.solve(record, random_generator(0, i), Deadline(None))
        for i, record in enumerate(run.records(period))
    ]


def alone(run: Run, period: float) -> list[Estimate]:
    """Solve every window by itself, as `solve_window`."""
    solver = Solver.of(run.plant.model, EstimationSettings(noise=given_noise(run)))
    return [
        solver.solve(record, random_generator(0, i), Deadline(None))
        for i, record in enumerate(run.records(period))
    ]


class Chained:
    """Solves windows with a prior from the one just before, however much they overlap."""

    def __init__(self, run: Run, period: float) -> None:
        self.solver = Solver.of(run.plant.model, EstimationSettings(noise=given_noise(run)))
        self.walk = JUMP_SETTINGS.prior_probability * period / run.plant.duration

    def prior(self, best: Hypothesis) -> Prior:
        """Return the posterior of the window before, widened by ours's random walk."""
        unknowns = self.solver.unknowns
        n = unknowns.n_states
        walked = np.diag(self.walk * unknowns.box_variances)
        return Prior.of(unknowns, best.point[n:], best.covariance[n:, n:] + walked)

    def solve(self, records: list[Record]) -> list[Estimate]:
        """Return the estimates of all windows."""
        estimates: list[Estimate] = []
        prior = Prior.box(self.solver.unknowns)
        for i, record in enumerate(records):
            previous = estimates[-1] if estimates else None
            estimate, best = self._solved(record, prior, previous, random_generator(0, i))
            estimates.append(estimate)
            prior = self.prior(best)
        return estimates

    def _solved(
        self, record: Record, prior: Prior, previous: Estimate | None, rng: np.random.Generator
    ) -> tuple[Estimate, Hypothesis]:
        solver, deadline = self.solver, Deadline(None)
        window = solver.pose(record, prior=prior, noise_known=True)
        warm = solver.warm_start(record, previous)
        window, found = solver.fit(window, window.posterior, rng, deadline, warm)
        best = hypothesis_at(PiecewiseProblem(window.objective, window.prior), found.z)
        information = marginal_information(best, solver.unknowns.n_states)
        # A misfit is no reason to withhold: that the contestant believes its prior is the point.
        uncertainty = Uncertainty(best, best.covariance, information)
        return report(window, found, uncertainty, in_time=True, solve_time=0.0), best


class Pulled(Chained):
    """Tikhonov's: every parameter stays near its previous estimate, whatever its covariance."""

    def prior(self, best: Hypothesis) -> Prior:
        """Return the previous estimate with a fixed standard deviation."""
        unknowns = self.solver.unknowns
        mean = best.point[unknowns.n_states :]
        return Prior.of(unknowns, mean, np.diag(np.full(mean.size, TIKHONOV**2)))


def kalman(run: Run, period: float) -> list[Estimate]:
    """Filter all samples; return the filter's estimates at the windows' ends."""
    kind: Any = load_observer('ekf')
    observer = kind(run.plant.model, noise=given_noise(run))
    stamps = np.round(NANOSECONDS * run.t).astype(np.int64).tolist()
    newest: dict[int, Estimate] = {}
    for stamp, u, y in zip(stamps, run.u, run.y, strict=True):
        observer.absorb(Sample(stamp, u=u))
        if observer.absorb(Sample(stamp, y=y)):
            estimate = observer.estimate()
            assert estimate is not None
            newest[stamp] = estimate
    records = run.records(period)
    ends = [round(NANOSECONDS * float(record.t[-1])) for record in records]
    starts = [float(record.t[0]) for record in records]
    return [replace(newest[end], t0=start) for end, start in zip(ends, starts, strict=True)]


OURS, EKF = 'ours', 'EKF'
CONTESTANTS: Mapping[str, Callable[[Run, float], list[Estimate]]] = {
    OURS: ours,
    'no prior': alone,
    'Tikhonov': lambda run, period: Pulled(run, period).solve(run.records(period)),
    'MAP arrival cost': lambda run, period: Chained(run, period).solve(run.records(period)),
    **({EKF: kalman} if 'ekf' in OBSERVERS else {}),
}
