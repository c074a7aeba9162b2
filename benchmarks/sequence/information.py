"""Table 6: windows solved alone, their errors against the Cramér-Rao bound and their intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.intervals import COVERED, covered
from benchmarks.report import rms, table
from benchmarks.sequence.scores import binomial
from benchmarks.tanks import PARAMETERS, STATES, TRUE_STEP, blank_record, random_window
from obs_ros import solve_window
from obs_ros.core.typing import Array, BoolArray
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK

SAMPLES = 300
UNKNOWNS = (*(f'{name} at the start' for name in STATES), *PARAMETERS)
VALUES = (*UNKNOWNS, *(f'{name} at the end' for name in STATES))
OPENINGS, LEVELS = (0.3, 0.9), (15.0, 85.0)
DIFFERENCE = 1e-4  # cm, and a hundredth of it for openings
FIRST = 500  # windows that the acceptance is about


class Informed(NamedTuple):
    """Errors, published deviations and Cramér-Rao bounds (N, 9) of N windows: see VALUES."""

    error: Array
    deviation: Array
    bound: Array
    crossing: BoolArray

    def only(self, chosen: BoolArray) -> 'Informed':
        """Return some windows, by a mask (N,)."""
        return Informed(*(values[chosen] for values in self))

    @property
    def coverage(self) -> Array:
        """Share (9,) of the intervals given that hold the truth."""
        given = np.isfinite(self.deviation)
        return np.asarray(covered(self.error, self.deviation).sum(axis=0) / given.sum(axis=0))

    @property
    def efficiency(self) -> tuple[Array, Array]:
        """Error over bound (9,), root mean square, with its margin."""
        value, ratio = rms(self.error / self.bound, 0), (self.error / self.bound) ** 2
        return value, COVERED * ratio.std(axis=0) / np.sqrt(len(ratio)) / (2.0 * value)


def bounds(truth: Array, sigma: float) -> Array:
    """Return the Cramér-Rao bounds (9,) on standard deviations, at true unknowns (6,)."""
    model = replace(THREE_TANK, max_step=TRUE_STEP)
    grid = Grid.of(model, blank_record(np.arange(float(SAMPLES))), np.ones(2))
    step = np.repeat((DIFFERENCE, 0.01 * DIFFERENCE), 3)
    lanes = truth[:, None] + np.hstack([np.diag(step), -np.diag(step)])
    states, _ = kernels_for(model).trajectories(
        grid, np.ascontiguousarray(lanes[:3]), np.ascontiguousarray(lanes[3:])
    )
    slopes = (states[:, :, :6] - states[:, :, 6:]) / (2.0 * step)
    jacobian = slopes[:, :2].reshape(-1, 6) / sigma
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    end = slopes[-1]
    variances = [np.diag(covariance), np.diag(end @ covariance @ end.T)]
    return np.asarray(np.sqrt(np.concatenate(variances)))


def informed(snr: float, seeds: Sequence[int]) -> Informed:
    """Solve windows one by one."""
    rows = []
    for seed in seeds:
        # Far from the bounds.
        drawn = random_window(seed, SAMPLES, snr, openings=OPENINGS, levels=LEVELS)
        one = solve_window(THREE_TANK, drawn.record, seed=seed)
        truth = np.array([drawn.truth[name] for name in (*STATES, *PARAMETERS)])
        values = (one.initial_state, one.parameters, one.state)
        found = [value for group in values for value in group.values()]
        deviation = [
            *(one.initial_stddev[name] for name in STATES),
            *(one.stddev[name] for name in (*PARAMETERS, *STATES)),
        ]
        error = np.array(found) - np.concatenate([truth, drawn.levels[-1]])
        rows.append((error, deviation, bounds(truth, drawn.sigma), drawn.crossing))
    return Informed(*(np.array(column) for column in zip(*rows, strict=True)))


def pooled(parts: Sequence[Informed]) -> Informed:
    """Return all windows as one."""
    return Informed(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def groups(cells: Mapping[float, Informed]) -> dict[str, Informed]:
    """Return the windows that are told apart."""
    found = {}
    for snr, own in cells.items():
        first = own.only(np.arange(len(own.error)) < FIRST)
        for label, part in (
            (f'first {len(first.error)}', first),
            (f'first {len(first.error)} without crossings', first.only(~first.crossing)),
            (f'all {len(own.error)}', own),
            (f'all without the {int(own.crossing.sum())} with crossings', own.only(~own.crossing)),
            ('crossings alone', own.only(own.crossing)),
        ):
            if len(part.error):
                found[f'{snr:g} dB, {label}'] = part
    return found


def coverage_table(cells: Mapping[float, Informed]) -> str:
    """Tell the coverage of every value."""
    return table(
        {
            'windows': name,
            'margin': f'± {binomial(0.95, len(own.error)):.3f}',
            **dict(zip(VALUES, (f'{share:.3f}' for share in own.coverage), strict=True)),
            'withheld': f'{np.mean(np.isnan(own.deviation)):.4f}',
        }
        for name, own in groups(cells).items()
    )


def efficiency_table(cells: Mapping[float, Informed]) -> str:
    """Tell the errors of every value against the bound."""
    rows = []
    for name, own in groups(cells).items():
        ratios = (f'{v:.3f} ± {m:.3f}' for v, m in zip(*own.efficiency, strict=True))
        rows.append({'windows': name, **dict(zip(VALUES, ratios, strict=True))})
    return table(rows)
