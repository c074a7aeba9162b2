"""Observers of flows that nobody measures, in an interconnected plant (Zhang et al. 2020).

    T_i' = f_i(T, u) + g_i(T, u) F_i,   F = c X,   y = T

with the process states T, the flows F and the actuators' states X, which have a model of their own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.interconnected_model import InterconnectedModel
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.typing import Array
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import Stepper, stepper_for
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.channels import products
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting

# Rates of F and of the filters, from t, F, the filters, inputs u, y, weights of y (0: not
# measured), the feed c X' of the actuators, p and the observer's settings.
FlowRates = Callable[[Any, Any, Any, Any, Any, Any, Any, Any, Any], tuple[Any, ...]]


@dataclass(frozen=True)
class FlowSettings(Settings):
    """Settings of all observers of flows."""

    step: ClassVar[float] = 0.1  # of the observer's shortest time constant: its longest RK4 step
    least_flow: ClassVar[float] = 1e-3  # of its upper bound, which residuals are relative to
    start_flow: float = setting(
        1.0, "share of the actuators' flow that the estimates start from; the paper starts from 0",
        lower=0.0, upper=5.0,
    )  # fmt: skip


class FlowObserver(RecursiveObserver):
    """Estimates the flows F of an InterconnectedModel from its outputs.

    The observer is an ordinary differential equation itself; a subclass writes it as a Model, see
    `observer_model`. Between two outputs y is a straight line; one that is missing corrects
    nothing. The process states start from the first output, unless an initial value is given.

    The actuator states come from the measured inputs and the actuators' model; `_correct` may move
    them. `figures` holds the flows by name and, as `residual_<flow>`, how far the modelled flow is
    above the estimated one: c X / F - 1. A fault of an actuator moves that, and only its own.
    """

    Settings = FlowSettings
    estimates_parameters = False
    model: InterconnectedModel

    @classmethod
    def suits(cls, model: Model) -> None:
        if not isinstance(model, InterconnectedModel):
            raise ValueError(
                f'{cls.__name__} needs a model that says how flows come about '
                f'(InterconnectedModel), and {model.name!r} does not'
            )

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        self._count = len(self.model.flows)
        self._opening = np.array(self.model.opening_index)
        self._least, self._most = np.array([(v.lower, v.upper) for v in self.model.flows]).T
        known = {**(self._arguments['initial'] or {}), **(self._arguments['fixed'] or {})}
        process = names(self.model.states)[: self._count]
        self._given = np.array([name in known for name in process])
        self._equations = self._observer()
        self._stepper: Stepper | None = None
        self._lanes = np.zeros((len(self._equations.states), LANES))
        tuning = np.concatenate([self.p, self._tuning()])
        self._parameters = np.repeat(tuning[:, None], LANES, axis=1)
        self.flows = np.zeros(self._count)
        self.filters = np.zeros(len(self._equations.states) - len(self.model.states))

    def _observer(self) -> Model:
        """Return the observer's differential equation."""
        raise NotImplementedError

    def _tuning(self) -> Array:
        """Return the values of its own parameters."""
        raise NotImplementedError

    def _read(self, now: Instant) -> None:
        """Take the process states from the filters."""
        self.x[: self._count] = self.filters

    def _start(self, now: Instant) -> None:
        r = self._count
        start = ~self._given & ~np.isnan(now.y)
        self.x[:r][start] = np.clip(now.y, self.lower[:r], self.upper[:r])[start]
        self.filters[:] = np.resize(self.x[:r], self.filters.size)
        modelled = np.array(self.model.flow_gain(self.p)) * self.x[self._opening]
        self.flows[:] = np.clip(self.settings.start_flow * modelled, self._least, self._most)
        self.innovation[:] = now.y - self.x[:r]
        self._report()

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        r, n = self._count, self.x.size
        if self._stepper is None:
            self._stepper = stepper_for(self._equations, self.backend)
        lanes = self._lanes
        lanes[:r] = self.flows[:, None]
        lanes[r:n] = self.x[r:, None]
        lanes[n:] = self.filters[:, None]
        self._stepper.propagate(self._with_outputs(path, before.y, now.y), lanes, self._parameters)
        self.flows[:] = np.minimum(np.maximum(lanes[:r, 0], self._least), self._most)
        self.x[r:], self.filters[:] = lanes[r:n, 0], lanes[n:, 0]
        self._read(now)
        self._correct((now.stamp - before.stamp) / 1e9)
        self.innovation[:] = now.y - self.x[:r]
        self._report()

    def _correct(self, dt: float) -> None:
        """Correct the actuator states by the flows, dt (s) after the last time."""

    def _with_outputs(self, path: Path, y0: Array, y1: Array) -> Path:
        """Return the path with the outputs and their weights among the inputs."""
        r, k, m = self._count, path.pieces, path.u.shape[1]
        begin, end = np.where(np.isnan(y0), y1, y0), np.where(np.isnan(y1), y0, y1)
        measured = ~np.isnan(begin)
        begin, end = np.where(measured, begin, 0.0), np.where(measured, end, 0.0)
        slope = (end - begin) / path.dt[:k].sum()
        u, slopes = np.zeros((k + 1, m + 2 * r)), np.zeros((k + 1, m + 2 * r))
        u[:, :m], slopes[:, :m] = path.u[: k + 1], path.slope[: k + 1]
        u[:, m : m + r], slopes[:, m : m + r] = begin, slope
        if k > 1:
            u[1:, m : m + r] += np.cumsum(path.dt[:k])[:, None] * slope
        u[:, m + r :] = measured
        steps = np.ceil(path.dt[:k] / self._equations.max_step - 1e-6).astype(np.int64)
        return Path(k, path.t, path.dt, np.maximum(steps, 1), u, slopes)

    def _expected(self, now: Instant, path: Path) -> Array:
        """Return the process states as they are: the model does not know the flows of a fault."""
        return self.x[: self._count].copy()

    def _report(self) -> None:
        modelled = np.array(self.model.flow_gain(self.p)) * self.x[self._opening]
        for flow, estimated, expected in zip(
            self.model.flows, self.flows.tolist(), modelled.tolist(), strict=True
        ):
            self.figures[flow.name] = estimated
            beside = max(estimated, self.settings.least_flow * flow.upper)
            self.figures[f'residual_{flow.name}'] = expected / beside - 1.0


def observer_model(
    model: InterconnectedModel,
    kind: str,
    filters: int,
    tuning: tuple[str, ...],
    rates: FlowRates,
    max_step: float,
) -> Model:
    """Return the differential equation of an observer of `model`, as a Model.

    Its states are the flows, the actuators' states and the `filters`; its inputs the plant's, y and
    the weights of y; its parameters the plant's and `tuning`, the observer's settings.
    """
    r, m, n = len(model.flows), len(model.inputs), len(model.states)
    q, weights = len(model.parameters), m + r
    plant, flow_gain = model.dynamics, model.flow_gain
    fed = products(model.opening_index)

    def dynamics(t: Any, x: Any, u: Any, p: Any) -> tuple[Any, ...]:
        flows, actuators, kept = x[:r], x[r:n], x[n:]
        given, inputs = p[:q], u[:m]
        # The actuators do not depend on the process, whose states only fill the places here.
        moving: tuple[Any, ...] = plant(t, kept[:r] + actuators, inputs, given)
        feed = fed(flow_gain(given), moving)
        own = rates(t, flows, kept, inputs, u[m:weights], u[weights:], feed, given, p[q:])
        return own[:r] + moving[r:] + own[r:]

    return Model(
        name=f'{model.name}_{kind}',
        states=(
            *model.flows,
            *model.states[r:],
            *(Variable(f'filter_{i}', lower=0.0, upper=1.0) for i in range(filters)),
        ),
        inputs=(
            *model.inputs,
            *(Variable(f'{v}_{n}') for v in ('y', 'weight') for n in names(model.outputs)),
        ),
        outputs=model.flows,
        parameters=(*model.parameters, *(Variable(name) for name in tuning)),
        dynamics=dynamics,
        output=lambda t, x, u, p: x[:r],
        max_step=min(max_step, model.max_step),
        reference=model.reference,
    )


def away(g: Any, least: float) -> Any:
    """Return g, at least so far from zero, with its sign."""
    return np.copysign(np.maximum(np.abs(g), least), g)


def clipped(F: Any, lower: float, upper: float) -> Any:
    """Return F within its bounds."""
    return np.minimum(np.maximum(F, lower), upper)


def inward(rate: Any, F: Any, lower: float, upper: float) -> Any:
    """Return the rate of F, without what would lead it further out of its bounds."""
    # Products, for np.where of single numbers compiles to something slow.
    return np.maximum(rate, 0.0) * (upper > F) + np.minimum(rate, 0.0) * (lower < F)
