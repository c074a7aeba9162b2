"""The plants whose sequences are watched, and their truth where parameters change."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.tanks import TRUE_STEP
from benchmarks.zoo.output import first_state
from obs_ros import Model, Record, Variable
from obs_ros.core.typing import Array
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.models.three_tank import THREE_TANK


def lag_dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any]:
    """Rate of a first-order lag: tau x' = k u - x."""
    k, tau = p
    return ((k * u[0] - x[0]) / tau,)


LAG = Model(
    name='first_order_lag',
    states=(Variable('x', lower=-10.0, upper=10.0),),
    inputs=(Variable('u'),),
    outputs=(Variable('y'),),
    parameters=(
        Variable('k', lower=0.2, upper=5.0, nominal=1.0),
        Variable('tau', unit='s', lower=1.0, upper=20.0, nominal=5.0),
    ),
    dynamics=lag_dynamics,
    output=first_state,
    max_step=0.1,
)


class Plant(NamedTuple):
    """A model with the windows that it is watched through: all times in s.

    `hold` is how long an input stays; valves and gains are drawn from `lower` to `upper` (q,).
    """

    model: Model
    step: float
    duration: float
    period: float
    hold: float
    feed: tuple[float, float]
    x0: tuple[float, float]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    @property
    def width(self) -> Array:
        """Widths (q,) of the parameters' boxes."""
        return np.array([v.upper - v.lower for v in self.model.parameters])

    @property
    def state_width(self) -> Array:
        """Widths (n,) of the states' boxes."""
        return np.array([v.upper - v.lower for v in self.model.states])


PLANTS = {
    'tanks': Plant(
        THREE_TANK, 1.0, 300.0, 50.0, 100.0, (5.0, 40.0), (20.0, 60.0), (0.4,) * 3, (0.95,) * 3
    ),
    'lag': Plant(LAG, 0.1, 30.0, 5.0, 15.0, (-1.0, 1.0), (-1.0, 1.0), (0.5, 1.5), (4.8, 18.0)),
}


class Change(NamedTuple):
    """A jump of parameter `place` by `size`, in its unit, at `time` (s)."""

    time: float
    place: int
    size: float


@dataclass(frozen=True)
class Parameters:
    """Piecewise constant: `values` (S, q) hold from `since` (S,) s on, the first one from 0 on."""

    since: Array
    values: Array

    @classmethod
    def of(cls, first: Array, changes: Sequence[Change] = ()) -> 'Parameters':
        """Return those that begin as `first` (q,) and then change."""
        values = [first]
        ordered = sorted(changes)
        for change in ordered:
            later = values[-1].copy()
            later[change.place] += change.size
            values.append(later)
        return cls(np.array([0.0, *(change.time for change in ordered)]), np.array(values))

    def before(self, t: Array) -> Array:
        """Return the values (K, q) up to times t (K,), at which they may change."""
        return np.asarray(self.values[np.searchsorted(self.since[1:], t, side='left')])


@dataclass(frozen=True)
class Run:
    """A stretch of measurements with its truth: times t (K,), u (K, m), y (K, r), states x (K, n).

    `sigma` is the noise's standard deviation at the start; `changes` are the jumps of parameters
    in it, and `event` (s) is when something happens that is not as assumed, if something does.
    """

    plant: Plant
    t: Array
    u: Array
    y: Array
    x: Array
    parameters: Parameters
    sigma: float
    changes: tuple[Change, ...] = ()
    event: float = np.inf

    def records(self, period: float) -> list[Record]:
        """Return the windows that end every `period` s."""
        step, duration = self.plant.step, self.plant.duration
        long = round(duration / step)
        ends = np.arange(long, self.t.size, round(period / step))
        parts = [slice(end - long + 1, end + 1) for end in ends]
        return [Record(self.t[part], self.u[part], self.y[part]) for part in parts]


def simulated(model: Model, t: Array, u: Array, x0: Array, parameters: Parameters) -> Array:
    """Return the true states (K, n) at t (K,), by steps a hundredth of the samples' interval."""
    nodes = np.union1d(t, parameters.since[parameters.since < t[-1]])
    held = u[np.searchsorted(t, nodes, side='right') - 1]
    fine = replace(model, max_step=min(TRUE_STEP, model.max_step / 10.0))
    kernels, outputs = kernels_for(fine), len(model.outputs)
    grid = Grid.of(fine, Record(nodes, held, np.zeros((nodes.size, outputs))), np.ones(outputs))
    places = [0, *np.searchsorted(nodes, parameters.since[1:]).tolist(), nodes.size - 1]
    states = np.empty((nodes.size, x0.size))
    x = x0[:, None]
    for p, first, last in zip(parameters.values, places, places[1:], strict=False):
        if first < last <= nodes.size - 1:
            stretch, _ = kernels.trajectories(grid.stretch(first, last), x, p[:, None])
            states[first : last + 1] = stretch[:, :, 0]
            x = np.ascontiguousarray(stretch[-1])
    return states[np.searchsorted(nodes, t)]
