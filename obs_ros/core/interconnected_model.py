"""A plant in two parts: a measured process, fed by flows from actuators that nobody measures."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.model import Model, PlantFunction, Variable, inside, names


@dataclass(frozen=True, kw_only=True)
class InterconnectedModel(Model):
    """A process x' = f(x) + g(x) F, measured as a whole, and actuators with F = c(p) X.

    Zhang et al. 2020, eq. 1-2. The first states are the process's and are the outputs, y = x; the
    others are the actuators'. There is one flow F for each output, which alone feeds that output's
    state (g is diagonal), and one actuator state, its opening X, that the flow is proportional to.

    `drift` is f and `gain` the diagonal of g, both as functions (t, x, u, p) of the process states
    only; `flow_gain` is c as a function of p. `openings` names the X. `flows` bounds the F;
    `least_gain` is the least size of g: where g passes zero, the output's rate says nothing of
    the flow. `opening_rates` names the states that are the X', if there are such.

    Raises ValueError for a wrong number of any of these, and where they are at odds with
    `dynamics` or `output`.
    """

    drift: PlantFunction
    gain: PlantFunction
    flow_gain: Callable[[Any], tuple[Any, ...]]
    openings: tuple[str, ...]
    flows: tuple[Variable, ...]
    least_gain: tuple[float, ...]
    opening_rates: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.kind == 'discrete':
            raise ValueError(f'model {self.name!r}: flows feed rates, which no discrete model has')
        count, order = len(self.outputs), names(self.states)
        for field in ('openings', 'flows', 'least_gain'):
            given = len(getattr(self, field))
            if given != count:
                raise ValueError(
                    f'model {self.name!r}: {field} has {given} entries for {count} outputs'
                )
        if len(self.opening_rates) not in (0, count):
            raise ValueError(
                f'model {self.name!r}: opening_rates has {len(self.opening_rates)} entries, not '
                f'{count} or none'
            )
        for name in (*self.openings, *self.opening_rates):
            if name not in order[count:]:
                raise ValueError(
                    f'model {self.name!r}: {name!r} is none of the actuator states '
                    f'{", ".join(order[count:])}'
                )
        self._compare()

    @property
    def opening_index(self) -> tuple[int, ...]:
        """Index of each flow's opening among all states."""
        return tuple(names(self.states).index(name) for name in self.openings)

    @property
    def rate_index(self) -> tuple[int, ...]:
        """Index among all states of the rate of each opening; empty where there is none."""
        return tuple(names(self.states).index(name) for name in self.opening_rates)

    def _compare(self) -> None:
        """Hold f + g c X against the dynamics, at one state, where no two values are alike."""
        count = len(self.outputs)
        x, u, p = (
            tuple(_within(v, k / len(group)) for k, v in enumerate(group))
            for group in (self.states, self.inputs, self.parameters)
        )
        process = x[:count]
        openings = np.array([x[i] for i in self.opening_index])
        flows = np.array(self.flow_gain(p)) * openings
        joined = np.array(self.drift(0.0, process, u, p)) + (
            np.array(self.gain(0.0, process, u, p)) * flows
        )
        rates = np.array(self.dynamics(0.0, x, u, p)[:count])
        if not np.allclose(joined, rates, rtol=1e-9, atol=0.0):
            raise ValueError(f'model {self.name!r}: f + g F is {joined}, but dynamics says {rates}')
        if not np.array_equal(self.output(0.0, x, u, p), process):
            raise ValueError(f'model {self.name!r}: outputs must be the first {count} states')


def _within(variable: Variable, share: float) -> float:
    """Return a value between the quarters of the bounds, where there are bounds."""
    width = variable.upper - variable.lower
    return variable.lower + (0.25 + 0.5 * share) * width if width < np.inf else inside(variable)
