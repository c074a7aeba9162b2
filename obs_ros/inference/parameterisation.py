"""The unknowns of an estimation as points z of the unit box, and the values that are given."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obs_ros.core.estimated_delays import is_delay
from obs_ros.core.jit import unhurried
from obs_ros.core.model import Model, Variable, check_bounds, names
from obs_ros.core.periods import nearest, periods
from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array, IntArray
from obs_ros.inference.scale import Scale

BOX_VARIANCE = 1.0 / 12.0  # of a uniform distribution over the box
STATE_SD = 10.0  # boxes: next to nothing is known of an initial state
REACH = 10.0  # of the nominal value, or units: where a search begins that has no bound
SMALLEST_STEP = 16  # units in the last place: smaller ones would be rounding
EPSILON = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Unknowns:
    """The estimated ones, d, among a model's n initial states and q parameters.

    index (d,) says which of the n + q values they are, `scale` in which boxes searches begin;
    given (n + q,) holds the values of the others. Searches see the boxes as [0, 1]^d, and may
    leave them where limits (2, d) are infinite.
    """

    model: Model
    index: IntArray
    scale: Scale
    given: Array
    limits: Array

    @classmethod
    def of(
        cls,
        model: Model,
        parameters: Iterable[str] | None = None,
        states: Iterable[str] | None = None,
        fixed: Mapping[str, float] | None = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
    ) -> 'Unknowns':
        """Estimate the named parameters and initial states; None means all that are not `fixed`.

        `fixed` gives values to others, whose default is their nominal value; `bounds` replaces the
        model's. Where a bound is infinite the search begins within ten times the nominal value, or
        ten units, of the nominal value or the other bound, and goes where the data lead; the mean
        of a prior stands before the nominal value.

        Raises ValueError for an unknown name, crossed bounds, a prior's mean outside them, a name
        both estimated and fixed, nothing to estimate, and a value that nobody gives.
        """
        fixed, bounds = dict(fixed or {}), dict(bounds or {})
        _check_given(model, fixed, bounds)
        chosen = (
            *_chosen('state', names(model.states), states, fixed),
            *_chosen('parameter', names(model.parameters), parameters, fixed),
        )
        if not chosen:
            raise ValueError(f'nothing to estimate: every unknown of {quoted(model.name)} is fixed')
        given = np.full(len(model.variables), np.nan)
        boxes, limits, growth = [], [], []
        for i, variable in enumerate(model.variables):
            if variable.name in chosen:
                low, high = bounds.get(variable.name, (variable.lower, variable.upper))
                check_bounds(variable.name, low, high, variable.scale)
                _check_prior(variable, low, high)
                box, limit = _beginning(variable, low, high)
                boxes.append(box)
                limits.append(limit)
                growth.append(math.log(high / low) if variable.scale == 'log' else 0.0)
                continue
            given[i] = _given(variable, fixed)
        index = [i for i, v in enumerate(model.variables) if v.name in chosen]
        lower, upper = np.array(boxes).T.copy()  # one layout, so that nothing compiles twice
        return cls(
            model=model,
            index=np.array(index),
            scale=Scale(lower, upper, np.array(growth)),
            given=given,
            limits=np.array(limits).T.copy(),
        )

    @property
    def dimension(self) -> int:
        """Number of unknowns, d."""
        return self.index.size

    @cached_property
    def n_states(self) -> int:
        """Number of estimated initial states; they come first."""
        return int(np.count_nonzero(self.index < len(self.model.states)))

    @cached_property
    def walks(self) -> Array:
        """Walks of the estimated parameters (q,), in boxes per root of a second.

        NaN for those that do not walk, but jump.
        """
        variables = self._variables[self.n_states :]
        walks = [np.nan if v.walk is None else v.walk for v in variables]
        return np.array(walks) / self.scale.unit[self.n_states :]

    @cached_property
    def priors(self) -> tuple[Array, Array]:
        """Means (d,) and standard deviations (d,) of the given priors, in boxes; NaN: none."""
        given = np.array([v.prior or (np.nan, np.nan) for v in self._variables]).reshape(-1, 2)
        mean, sd = given.T
        relative = sd / np.where(self.scale.growth > 0.0, mean, 1.0)
        return self.scale.places(mean), relative / self.scale.unit

    @cached_property
    def box_variances(self) -> Array:
        """Variances (q,) of estimated parameters of which only the bounds are known."""
        bounded = np.isfinite(self.limits[:, self.n_states :]).all(axis=0)
        found = np.where(bounded, BOX_VARIANCE, STATE_SD**2)
        found.flags.writeable = False
        return found

    @cached_property
    def box_precisions(self) -> tuple[Array, Array]:
        """Precision (d, d) of unknowns anywhere in their boxes, and the parameters' part of it."""
        parameters, states = 1.0 / self.box_variances, np.zeros(self.n_states)
        boxes = np.diag(np.append(states, parameters))
        return np.diag(np.append(states + 1.0 / STATE_SD**2, parameters)), boxes

    @cached_property
    def may_jump(self) -> list[int]:
        """Places of the parameters that may jump: not disturbances, which wander anyway.

        Nor do delays: what goes off in time is a clock or a queue, and drifts.
        """
        places = (self.n_states + np.flatnonzero(np.isnan(self.walks))).tolist()
        return [place for place in places if not is_delay(self.names[place])]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, states first."""
        return names(self._variables)

    @cached_property
    def _variables(self) -> tuple[Variable, ...]:
        return tuple(self.model.variables[i] for i in self.index)

    def values(self, z: Array) -> tuple[Array, Array]:
        """Return initial states (n, B) and parameters (q, B) of points z (B, d) of the unit box."""
        everything = np.repeat(self.given[:, None], len(z), axis=1)
        everything[self.index] = self.scale.values(z).T
        n = len(self.model.states)
        return everything[:n], everything[n:]

    def check_initial(self, values: Mapping[str, float]) -> None:
        """Raise ValueError unless the values to start from are finite and of what is estimated."""
        self.check_estimated('an initial value', values)
        for name, value in values.items():
            if not np.isfinite(value):
                raise ValueError(f'{name} starts from {value}, which is not a finite number')

    def check_estimated(self, what: str, given: Iterable[str]) -> None:
        """Raise ValueError unless everything that is given `what`, by name, is estimated."""
        for name in given:
            self.model.variable(name)
            if name not in self.names:
                raise ValueError(f'{name} cannot have {what}: it is not estimated')

    def prepare(self) -> None:
        """Compile what `perturbed` needs, or load it compiled."""
        middle = np.full((1, self.dimension), 0.5)
        self.perturbed(middle, np.full_like(middle, 1e-8))

    def perturbed(self, z: Array, h: Array) -> tuple[Array, Array, Array]:
        """Return x0 (n, P (1 + d)), p (q, P (1 + d)) and the steps (P, d) really taken.

        One start after the other: its point, of z (P, d), then that with its h_i added to each
        z_i, of h (P, d). Rounding changes the steps.
        """
        n = len(self.model.states)
        scale = self.scale
        lanes, steps = _perturbed(
            z, h, scale.lower, scale.upper, scale.growth, self.index, self.given
        )
        return lanes[:n], lanes[n:], steps

    def point(self, values: Mapping[str, float]) -> Array:
        """Return the point z (d,) nearest to named values; NaN becomes the middle of the box.

        A state with a period has its value in the box, or nearest to it, whole periods away.
        """
        given = np.array([values[name] for name in self.names])
        middle = 0.5 * (self.scale.lower + self.scale.upper)
        z = self.scale.places(nearest(given, middle, periods(self._variables)))
        return np.clip(np.where(np.isfinite(z), z, 0.5), *self.limits)


@unhurried
def _perturbed(
    z: Array, h: Array, lower: Array, upper: Array, growth: Array, index: IntArray, given: Array
) -> tuple[Array, Array]:
    starts, d = z.shape
    lanes = np.empty((given.size, starts * (d + 1)))
    steps = np.empty((starts, d))
    for row in range(given.size):
        lanes[row] = given[row]
    for s in range(starts):
        first = s * (d + 1)
        for i in range(d):
            slope = upper[i] - lower[i]
            point = lower[i] + z[s, i] * slope
            if growth[i] > 0.0:
                point = min(lower[i] * math.exp(z[s, i] * growth[i]), upper[i])
                slope = growth[i] * point
            for lane in range(first, first + d + 1):
                lanes[index[i], lane] = point
            # In a very narrow box a step must still change the value.
            step = max(abs(h[s, i]) * slope, SMALLEST_STEP * EPSILON * abs(point))
            lanes[index[i], first + 1 + i] = point + (step if h[s, i] > 0.0 else -step)
            steps[s, i] = (lanes[index[i], first + 1 + i] - point) / slope
            if growth[i] > 0.0:
                steps[s, i] = math.log1p(growth[i] * steps[s, i]) / growth[i]
    return lanes, steps


def _check_given(
    model: Model, fixed: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]
) -> None:
    """Raise ValueError for unknown names, and for values that are none."""
    for name, level in fixed.items():
        model.variable(name)
        if not np.isfinite(level):  # a measured one may well lie outside the bounds
            raise ValueError(f'{name} is fixed at {level}, which is not a finite number')
    for name, pair in bounds.items():
        model.variable(name)
        if np.shape(pair) != (2,):
            raise ValueError(f'bounds of {name} must be (lower, upper), not {quoted(pair)}')


def _check_prior(variable: Variable, low: float, high: float) -> None:
    """Raise ValueError for a prior whose mean is outside the bounds."""
    if variable.prior is not None and not low <= variable.prior[0] <= high:
        raise ValueError(
            f'{variable.name}: widen the bounds, or correct the prior: its mean '
            f'{variable.prior[0]} is outside [{low}, {high}]'
        )


def _given(variable: Variable, fixed: Mapping[str, float]) -> float:
    """Return the value of a variable that is not estimated."""
    value = fixed.get(variable.name, variable.nominal)
    if value is None or not np.isfinite(value):
        raise ValueError(
            f'{variable.name} is not estimated and has no nominal value: '
            f'give it a fixed value, in {variable.unit}'
        )
    return value


def _beginning(
    variable: Variable, low: float, high: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return finite bounds to begin a search in, and the limits of places in that box.

    Bounds a period apart, or more, are none: the box is one period.
    """
    nominal = variable.nominal if variable.prior is None else variable.prior[0]
    if variable.period is not None and not high - low < variable.period:
        middle = 0.5 * (low + high) if np.isfinite(high - low) else 0.0
        middle = middle if nominal is None else nominal
        half = 0.5 * variable.period
        return (middle - half, middle + half), (-math.inf, math.inf)
    limit = 0.0 if np.isfinite(low) else low, 1.0 if np.isfinite(high) else high
    origin = nominal if nominal is not None else next((b for b in (low, high) if np.isfinite(b)), 0)
    reach = REACH * max(abs(nominal or 0.0), 1.0)
    box = (
        low if np.isfinite(low) else min(origin, high) - reach,
        high if np.isfinite(high) else max(origin, low) + reach,
    )
    return box, limit


def _chosen(
    kind: str, known: tuple[str, ...], wanted: Iterable[str] | None, fixed: Mapping[str, float]
) -> tuple[str, ...]:
    if wanted is None:
        return tuple(name for name in known if name not in fixed)
    if isinstance(wanted, str):
        wanted = (wanted,)
    wanted = tuple(wanted)
    for name in wanted:
        if name not in known:
            raise ValueError(f'no {kind} {quoted(name)} to estimate: {suggest(name, known)}')
        if name in fixed:
            raise ValueError(f'{kind} {quoted(name)} cannot be both estimated and fixed')
    return wanted
