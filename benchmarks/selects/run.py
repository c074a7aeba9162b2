"""Time of rollouts of plants whose functions choose, beside like ones that do not, in one run.

Work of a candidate-step: one RK4 step and the squared residuals of the outputs, of 64 candidates
over 1000 samples.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.common import cpu_seconds, machine, mark, options, publish, repeats_for
from benchmarks.common import table as markdown
from benchmarks.selects.models import PLANTS
from obs_ros import Model, Record
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid

CANDIDATES = 64
SAMPLES = 1000
MEASUREMENT = 0.005  # s of process time
LIMIT = 1.3  # times the plain step


class Row(NamedTuple):
    """Fastest of the measurements in ns per candidate-step, and the median ratio to the plain."""

    plant: str
    choice: str
    plain: float
    ours: float
    ratio: float


def main(arguments: list[str] | None = None) -> list[Row]:
    """Measure, print, and write the report."""
    parser = options(__doc__)
    parser.add_argument('--rounds', type=int, default=41, help='interleaved measurements')
    chosen = parser.parse_args(arguments)
    rows = [
        measured(plant, choice, plain, model, chosen.rounds)
        for plant, (plain, models) in PLANTS.items()
        for choice, model in models.items()
    ]
    publish(chosen.results, 'selects', 'Plants that choose', report(rows, chosen.rounds), machine())
    return rows


def measured(plant: str, choice: str, plain: Model, model: Model, rounds: int) -> Row:
    """Interleave the measurements of a plant that chooses and the one that does not."""
    calls = [rollout(each) for each in (plain, model)]
    counts = [repeats_for(call, MEASUREMENT) for call in calls]
    times = np.array(
        [
            [cpu_seconds(call, count) for call, count in zip(calls, counts, strict=True)]
            for _ in range(rounds)
        ]
    )
    unit = 1e9 / (CANDIDATES * (SAMPLES - 1))
    fastest = times.min(axis=0) * unit
    return Row(plant, choice, *map(float, fastest), float(np.median(times[:, 1] / times[:, 0])))


def rollout(model: Model) -> Callable[[], Array]:
    """Return a call that rolls candidates of the model out, after a check against NumPy."""
    grid, x0, p = window(model, SAMPLES, CANDIDATES)
    prefixes = np.array([SAMPLES])
    compiled = kernels_for(model, 'numba')
    short, few = np.array([50]), slice(0, 16)
    np.testing.assert_allclose(
        compiled.squares(grid, short, x0[:, few], p[:, few]),
        kernels_for(model, 'numpy').squares(grid, short, x0[:, few], p[:, few]),
        rtol=1e-9,
    )
    return lambda: compiled.squares(grid, prefixes, x0, p)


def window(model: Model, samples: int, candidates: int) -> tuple[Grid, Array, Array]:
    """Return a grid of samples one step apart, and states and parameters within the bounds."""
    rng = np.random.default_rng(0)
    t = model.max_step * np.arange(samples)
    u = rng.uniform(0.0, 1.0, (samples, len(model.inputs)))
    y = np.zeros((samples, len(model.outputs)))
    grid = Grid.of(model, Record(t, u, y), np.ones(len(model.outputs)))
    x0, p = (
        np.array([rng.uniform(v.lower, v.upper, candidates) for v in group])
        for group in (model.states, model.parameters)
    )
    return grid, x0, p


def report(rows: list[Row], rounds: int) -> list[str]:
    """Return the parts of the report."""
    head = ('plant', 'chooses by', 'plain (ns)', 'choosing (ns)', 'ratio', 'limit', 'within')
    lines = [
        (
            row.plant, row.choice, f'{row.plain:.1f}', f'{row.ours:.1f}', f'{row.ratio:.2f}',
            f'{LIMIT}', mark(row.ratio <= LIMIT),
        )
        for row in rows
    ]  # fmt: skip
    return [
        'Process time per candidate and RK4 step with the squared residuals of the outputs, of '
        f'{CANDIDATES} candidates; the fastest of {rounds} interleaved measurements, the ratio '
        'being the median of their ratios. The plain plant has the same terms, linear instead of '
        'chosen. Each was checked against NumPy (rtol 1e-9).',
        markdown(head, lines),
    ]
