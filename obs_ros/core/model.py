"""The model of a plant: named variables with units and bounds, and two plain functions."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, Literal, get_args

import numpy as np

from obs_ros.core import estimated_delays
from obs_ros.core.model_kind import DISCRETE, Kind, check_signals, check_stepping
from obs_ros.core.plant_function import Trial, normalised
from obs_ros.core.registry import suggest
from obs_ros.core.typing import Array
from obs_ros.core.variable_fields import (
    SENSOR_FIELDS,
    check_kind,
    checked_prior,
    checked_sensor_field,
    number,
)

Interpolation = Literal['hold', 'linear', 'mean']
Scale = Literal['linear', 'log']
Physical = Literal['none', 'lower', 'upper', 'both']
Integrator = Literal['auto', 'rk4', 'euler', 'rosenbrock', 'discrete']
Method = Literal['rk4', 'euler', 'rosenbrock', 'discrete']
Time = Literal['stamp', 'window']

CANDIDATES = 16  # with which a model is tried

# f(t, x, u, p) -> one entry per state or output, each a float. In a Model it returns a tuple, of
# floats or of arrays over candidates.
PlantFunction = Callable[[Any, Any, Any, Any], Any]


@dataclass(frozen=True)
class Variable:
    """One state, input, output or parameter of a plant.

    `lower` and `upper` bound it, in `unit`; `nominal` is its value when nobody estimates it.
    `interpolation` says what an input does between its samples: `hold` the last one, run `linear`
    to the next, or stay at the `mean` of both. `scale` says how far apart searches and priors see
    two values of a parameter: `log` where it counts how many times larger one is than the other, as
    with stiffnesses, rates and whatever enters in products and powers; values of equal product then
    lie on a straight line. `walk` makes a parameter a disturbance: how far it wanders in one
    second, as a standard deviation in units per square root of a second (on a log scale, of its
    logarithm), infinite for one that is new in every window. Without it a parameter stays where it
    is, or jumps. On a state `walk` is process noise, which `process_noise: given` takes as it is.
    `prior` is the knowledge of a parameter, or of a state at the start, before anything is
    measured: mean and standard deviation of a normal distribution, in `unit`. On a log scale the
    logarithm is normal, its deviation to first order the ratio of both. `physical` names
    the bounds of a parameter that the plant cannot leave, as the `lower` one of a friction: an
    interval may end there. Other bounds are a guess, and what reaches them is not determined.

    Sensors and actuators are declared as they are. `period`, in `unit`, belongs to an output or
    state that wraps, as an angle does at 2 pi. `range` (low, high), in `unit`, is where a sensor
    saturates, or to which an actuator clips its input; one end may be infinite. `resolution`, in
    `unit`, is the step between two values that a sensor can report. `delay`, in s, says how long
    before its stamp an output was measured, or how long after its stamp an input acts; two numbers
    (lower, upper) bound a delay that is estimated.

    Numbers are floats, whether given as such or as integers.

    Raises ValueError for a name that is no identifier, what is no number, crossed bounds, bounds
    that a logarithm does not have, a nominal outside them, a walk, period or resolution that is not
    positive, a prior without a finite mean, positive on a log scale, and a finite, positive
    standard deviation, a range that limits nothing, and a delay beyond +-1e6 s.
    """

    name: str
    unit: str = '1'
    lower: float = -math.inf
    upper: float = math.inf
    nominal: float | None = None
    interpolation: Interpolation = 'hold'
    walk: float | None = None
    scale: Scale = 'linear'
    prior: tuple[float, float] | None = None
    physical: Physical = 'none'
    _: KW_ONLY
    period: float | None = None
    range: tuple[float, float] | None = None
    resolution: float | None = None
    delay: float | tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not estimated_delays.signal_of(self.name).isidentifier():
            raise ValueError(f'variable name {self.name!r} is not an identifier')
        for field in ('lower', 'upper', 'nominal', 'walk'):
            value = getattr(self, field)
            if value is not None or field in ('lower', 'upper'):
                object.__setattr__(self, field, number(f'{self.name}: {field}', value))
        for field, words in (
            ('scale', Scale), ('interpolation', Interpolation), ('physical', Physical)
        ):  # fmt: skip
            if (word := getattr(self, field)) not in get_args(words):
                raise ValueError(
                    f'{self.name}: {field} {word!r} is none of {", ".join(get_args(words))}'
                )
        check_bounds(self.name, self.lower, self.upper, self.scale)
        if self.nominal is not None and not self.lower <= self.nominal <= self.upper:
            raise ValueError(
                f'{self.name}: nominal {self.nominal} is outside [{self.lower}, {self.upper}]'
            )
        if self.walk is not None and not self.walk > 0.0:
            raise ValueError(f'{self.name}: walk {self.walk} is not positive')
        if self.prior is not None:
            log = self.scale == 'log'
            object.__setattr__(self, 'prior', checked_prior(self.name, self.prior, log))
        for field in SENSOR_FIELDS:
            if (value := getattr(self, field)) is not None:
                object.__setattr__(self, field, checked_sensor_field(self.name, field, value))

    @property
    def rounding(self) -> float:
        """Standard deviation of the errors by which a sensor rounds; 0 where that is not known.

        Steps of size d leave errors of variance d^2 / 12 (Widrow & Kollar 2008, chapter 5).
        """
        return (self.resolution or 0.0) / math.sqrt(12.0)


@dataclass(frozen=True)
class Model:
    """A plant x' = f(t, x, u, p), or x_(k+1) = f(t, x, u, p); y = h(t, x, u, p).

    `dynamics` and `output` take the time t in s and tuples x (states), u (inputs), p (parameters),
    and return one number for each state or output, as a tuple, a list or an array. They are
    written as for plain numbers. Straight-line functions of NumPy on tuples stay as they are;
    others are recorded when the model is made (`core.tracing`): loops, arrays, matrices, branches,
    methods of objects become such functions, and constants keep the values that they have then.
    `integrator` names the steps: `rk4` and `euler` are explicit, `rosenbrock` is linearly implicit
    for stiff plants; `auto` chooses, as the noise asks for. `max_step` (s) limits their length.

    `kind` says what `dynamics` returns: rates (`continuous`), or the state one `period` (s) later
    (`discrete`), from the state and the inputs in force at a node. Steps of a discrete model lead
    from node to node; a walk adds its square times the period to the variance at each.

    `time` says what t is: the sample's `stamp` in s, which with ROS counts from 1970 unless time is
    simulated, or the time since the start of the `window`. Then what depends on t begins anew in
    every window; only sliding windows have such a time. The simulator's t counts from its start.

    Each delay that is to be estimated is one more parameter, `<signal>.delay` in s, after those
    that are given; the functions get those alone.

    Raises ValueError when names clash, a step is not positive, a state's walk is infinite, or a
    function takes its arguments in another order, fails, returns something else than one number
    for each entry, or is finite nowhere; with the line at fault.
    """

    name: str
    states: Sequence[Variable]
    outputs: Sequence[Variable]
    dynamics: PlantFunction
    output: PlantFunction
    inputs: Sequence[Variable] = ()
    parameters: Sequence[Variable] = ()
    max_step: float = math.inf
    integrator: Integrator = 'auto'
    reference: str = ''
    time: Time = 'stamp'
    kind: Kind = 'continuous'
    period: float | None = None

    def __post_init__(self) -> None:
        for field in ('states', 'inputs', 'outputs', 'parameters'):
            object.__setattr__(self, field, tuple(getattr(self, field)))
        if not self.states or not self.outputs:
            raise ValueError(f'model {self.name!r} needs at least one state and one output')
        own = estimated_delays.own_parameters(self.parameters)
        signals = (*self.inputs, *self.outputs)
        delays = estimated_delays.unknowns(signals, self.parameters, Variable)
        object.__setattr__(self, 'parameters', (*own, *delays))
        for group in (self.variables, tuple(self.inputs), tuple(self.outputs)):
            names = [variable.name for variable in group]
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise ValueError(f'model {self.name!r} has more than one variable {twice[0]!r}')
        stepping = self.kind, self.period, self.integrator, self.max_step, get_args(Integrator)
        checked = check_stepping(self.name, *stepping)
        for field, value in zip(('period', 'integrator', 'max_step'), checked, strict=True):
            object.__setattr__(self, field, value)
        if self.kind == DISCRETE:
            check_signals(self.name, self.inputs, self.outputs)
        if self.time not in get_args(Time):
            known = ', '.join(get_args(Time))
            raise ValueError(f'model {self.name!r}: time {self.time!r} is none of {known}')
        for variable in (*self.states, *self.inputs, *self.outputs):
            if variable.scale != 'linear':
                raise ValueError(
                    f'model {self.name!r}: {variable.name} has scale {variable.scale!r}, '
                    'which only parameters may have'
                )
        for kind in ('state', 'input', 'output', 'parameter'):
            for variable in getattr(self, f'{kind}s'):
                given = [f for f in SENSOR_FIELDS if getattr(variable, f) is not None]
                check_kind(f'model {self.name!r}: {variable.name}', kind, given)
        for variable in self.states:
            if variable.walk == math.inf:
                raise ValueError(
                    f'model {self.name!r}: give state {variable.name} a finite walk, not inf, '
                    'which only parameters may have'
                )
        for function, entries in (('dynamics', self.states), ('output', self.outputs)):
            made = self._normalised(function, entries, own)
            if len(own) < len(self.parameters):
                made = estimated_delays.of_first(made, len(own))
            object.__setattr__(self, function, made)

    def _normalised(
        self, kind: str, entries: Sequence[Variable], parameters: Sequence[Variable]
    ) -> PlantFunction:
        """Return a function as all backends run it, tried with arrays over candidates."""
        rng = np.random.default_rng(0)
        groups = self.states, self.inputs, parameters
        values = (tuple(_around(variable, rng) for variable in group) for group in groups)
        vectors = dict(zip('xup', map(names, groups), strict=True))
        # Of NumPy's kind, as in rollouts: 1 / t is infinite then, and raises no error.
        trial = Trial((np.float64(0.0), *values), vectors, names(entries), CANDIDATES)
        try:
            return normalised(estimated_delays.plain(getattr(self, kind)), trial)
        except ValueError as error:
            raise ValueError(f'model {self.name!r}: {kind} {error}') from error

    @property
    def method(self) -> Method:
        """The integration method that was given, RK4 until another is chosen where it is `auto`."""
        return 'rk4' if self.integrator == 'auto' else self.integrator

    @property
    def variables(self) -> tuple[Variable, ...]:
        """All that can be estimated, states, then parameters, in the order of every vector."""
        return (*self.states, *self.parameters)

    def variable(self, name: str) -> Variable:
        """Return the state or parameter called `name`; raises ValueError when there is none."""
        for variable in self.variables:
            if variable.name == name:
                return variable
        known = [variable.name for variable in self.variables]
        raise ValueError(f'model {self.name!r} has no state or parameter {name!r}: '
                         f'{suggest(name, known)}')  # fmt: skip


def names(variables: Sequence[Variable]) -> tuple[str, ...]:
    """Return the names of the variables, in their order."""
    return tuple(variable.name for variable in variables)


def check_bounds(name: str, lower: float, upper: float, scale: Scale = 'linear') -> None:
    """Raise ValueError unless lower < upper, with logarithms where the scale needs them."""
    if not lower < upper:
        raise ValueError(f'{name}: lower bound {lower} is not below upper bound {upper}')
    if scale == 'log' and not (lower > 0.0 and upper < math.inf):
        raise ValueError(
            f'{name}: bounds {lower} and {upper} must be positive and finite on a log scale'
        )


def inside(variable: Variable) -> float:
    """Return the nominal value, or else a value well inside the bounds."""
    if variable.nominal is not None:
        return variable.nominal
    lower, upper = variable.lower, variable.upper
    if math.isinf(lower) and math.isinf(upper):
        return 1.0
    if math.isinf(upper):
        return lower + 1.0
    return upper - 1.0 if math.isinf(lower) else 0.5 * (lower + upper)


def _around(variable: Variable, rng: np.random.Generator) -> Array:
    """Return values (CANDIDATES,) to try: the nominal one, or else the middle and others inside."""
    middle = inside(variable)
    if variable.nominal is not None:
        return np.full(CANDIDATES, middle)
    width = variable.upper - variable.lower
    share = rng.uniform(-0.5, 0.5, CANDIDATES)
    share[0] = 0.0
    return np.asarray(middle + share * (width if math.isfinite(width) else 1.0))


def checked_noise(model: Model, noise: Mapping[str, float] | None) -> dict[str, float]:
    """Return the standard deviations by output, those of rounding sensors with `rounding`.

    Raises ValueError for what cannot be a standard deviation.
    """
    if noise is not None and not isinstance(noise, Mapping):
        raise ValueError(f'noise must give a standard deviation by output, not {noise!r}')
    outputs = names(model.outputs)
    for name, sd in (noise or {}).items():
        if name not in outputs:
            raise ValueError(f'noise of unknown output {name!r}: {suggest(name, outputs)}')
        if not (math.isfinite(sd) and sd > 0.0):
            raise ValueError(f'noise of {name}: standard deviation {sd} is not positive')
    given = dict(noise or {})
    for variable in model.outputs:
        if variable.resolution is not None and variable.name in given:
            given[variable.name] = math.hypot(given[variable.name], variable.rounding)
    return given
