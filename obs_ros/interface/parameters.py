"""The estimator's parameters: a table for all observers, and those of a model and an observer."""

import math
import re
from typing import Any, get_args

from obs_ros.core.model import Model, Variable
from obs_ros.core.parameter_spec import LARGEST_SEED, ParameterSpec
from obs_ros.inference.objective import FITNESSES, LOSSES
from obs_ros.inference.process_noise import MODES
from obs_ros.observers.base import load_observer
from obs_ros.observers.settings import parameter_specs
from obs_ros.optimization.differential_evolution import Strategy
from obs_ros.optimization.initial_population import POPULATIONS
from obs_ros.optimization.methods import METHODS
from obs_ros.samples.range_check import LARGEST

ALL, NONE = 'all', 'none'
NOTHING = (0.0, 0.0)  # the prior of which nothing is known

# Declared by rclpy and rcl themselves, wherever the user says so: no business of these tables.
_FOREIGN = re.compile(r'use_sim_time|start_type_description_service|qos_overrides\..*')

# Old names of parameters, with the new ones.
RENAMED = {'predict': 'prediction.enabled', 'predict.rate': 'prediction.rate'}

# They say what is loaded: a remote `param set` must never import code.
CHOICE = (
    ParameterSpec('model', 'three_tank',
        'plant model: a built-in name or package.module:ATTRIBUTE', read_only=True),
    ParameterSpec('observer', 'sliding_window',
        'observer: a built-in name or package.module:CLASS', read_only=True),
    ParameterSpec('merge_wait', 0.1,
        'wall time that samples wait for older ones on other topics: where `signals` name several, '
        'and outputs for inputs that are due, 1 s at most',
        's', lower=0.0, upper=60.0, read_only=True),
    ParameterSpec('managed', False,
        'a managed node, which waits for the transitions of its lifecycle: configure, activate',
        read_only=True),
    ParameterSpec('checkpoint', '',
        'file that what windows have learned survives a restart in, or a folder for one file a '
        "node; '': none", read_only=True),
)  # fmt: skip

# A change of these needs no new observer. Immediate observers need neither deadline nor prediction.
LIVE = (
    ParameterSpec('deadline', 1.0, 'wall time for one solve, best so far when it ends', 's',
        positive=True, upper=3600.0),
    ParameterSpec('stale_after', 5.0,
        'wall time without samples after which a stream is stale', 's', positive=True, upper=1e6),
    ParameterSpec('prediction.enabled', True,
        'publish ~/prediction, the state carried on to the newest output, and ~/residual'),
    ParameterSpec('prediction.rate', 0.0,
        'predictions per s of sample time at most; 0: one for every output', 'Hz',
        lower=0.0, upper=1e6),
)  # fmt: skip

COMMON = (
    ParameterSpec('window.duration', 1000.0, 'length of a window, in sample time', 's',
        lower=1e-3, upper=1e9),
    ParameterSpec('window.period', 0.0,
        'from one window to the next; 0: the duration, so they abut', 's', lower=0.0, upper=1e9),
    ParameterSpec('window.capacity', 100000,
        'samples of a stream kept at most; the oldest are dropped', lower=2, upper=1_000_000),
    ParameterSpec('parameters', (ALL,),
        f"names of the parameters to estimate; ['{ALL}'] or ['{NONE}'] for all or none"),
    ParameterSpec('states', (ALL,),
        f"names of the initial states to estimate; ['{ALL}'] or ['{NONE}'] for all or none"),
    ParameterSpec('learn_noise', False,
        'true: `noise.*` is a starting value, re-estimated from accepted windows; false: it stays'),
    ParameterSpec('process_noise', 'auto',
        'walks of the states inside a window: off; auto: found where the model alone does not '
        'explain it; given: those of the model, or `walk.*`', choices=MODES),
    ParameterSpec('loss', LOSSES[0],
        'robust: outliers and bursts of a sensor are left out, told and counted; squares: they '
        'count like all else', choices=LOSSES),
    ParameterSpec('fitness', FITNESSES[0], 'misfit that the search minimises', choices=FITNESSES),
    ParameterSpec('seed', 0, 'seed of the search; the same samples then give the same estimates',
        lower=0, upper=LARGEST_SEED),
    ParameterSpec('search.method', 'memetic', 'search method', choices=tuple(METHODS)),
    ParameterSpec('search.chaos', '', "first population; '': the method's own",
        choices=('', *POPULATIONS)),
    ParameterSpec('search.population', 0, "candidates (Np); 0: the method's own",
        lower=0, upper=100_000),
    ParameterSpec('search.generations', 0, "generations (Gm) at most; 0: the method's own",
        lower=0, upper=1_000_000),
    ParameterSpec('search.strategy', '', "mutation and crossover; '': the method's own",
        choices=('', *get_args(Strategy))),
    ParameterSpec('search.differential_weight', 0.0,
        "differential weight F; 0: the method's own", lower=0.0, upper=2.0),
    ParameterSpec('search.crossover', 0.0,
        "crossover probability CR; 0: the method's own", lower=0.0, upper=1.0),
)  # fmt: skip

# Immediate observers share these with those that solve windows.
SHARED = ('stale_after', 'parameters', 'states', 'seed')


def observer_parameters(model: Model, name: str) -> tuple[ParameterSpec, ...]:
    """Return the parameters that the observer of that name has on that model.

    Raises ValueError when there is no such observer.
    """
    observer: Any = load_observer(name)
    if not observer.immediate:
        start = 'in a start that the next window tries beside its own; nan: mid of bounds'
        return (*LIVE, *COMMON, *model_parameters(model), *initial_parameters(model, start),
                *prior_parameters(model))  # fmt: skip
    start = "at the start; nan: the observer's own, nominal or mid of bounds"
    return (
        *(spec for spec in (*LIVE, *COMMON) if spec.name in SHARED),
        *parameter_specs(observer.Settings, own_prefix(name)),
        *model_parameters(model, "the observer's own"),
        *initial_parameters(model, start),
        *(prior_parameters(model) if takes_priors(observer) else ()),
    )


def initial_parameters(model: Model, start: str) -> tuple[ParameterSpec, ...]:
    """Return the parameters for the start of the estimates; `start` is its meaning in words."""
    return tuple(
        ParameterSpec(f'initial.{v.name}', math.nan, f'{v.name} {start}', v.unit,
            lower=-LARGEST, upper=LARGEST, nan=True)
        for v in model.variables
    )  # fmt: skip


def prior_parameters(model: Model) -> tuple[ParameterSpec, ...]:
    """Return the parameters for what is known of the variables: their walks and their priors."""
    return (
        *(ParameterSpec(f'walk.{v.name}', v.walk or 0.0, _wandering(v), walk_unit(v),
            lower=0.0, upper=LARGEST, infinite=v in model.parameters)
          for v in model.variables),
        *(ParameterSpec(f'prior.{v.name}', v.prior or NOTHING,
            f'mean and standard deviation of {v.name} before anything is measured; '
            '[0, 0]: nothing is known', v.unit, lower=-LARGEST, upper=LARGEST, length=2)
          for v in model.variables),
    )  # fmt: skip


def _wandering(variable: Variable) -> str:
    what = 'the logarithm of ' if variable.scale == 'log' else ''
    return f'standard deviation that {what}{variable.name} wanders by in 1 s; 0: not known, or none'


def walk_unit(variable: Variable) -> str:
    """Return the unit of a variable's walk; on a log scale it is one of the logarithm."""
    unit = '1' if variable.scale == 'log' else variable.unit
    return f'{unit}/sqrt(s)'


def takes_priors(observer: Any) -> bool:
    """Whether an observer class takes walks and priors of the model's variables."""
    return getattr(observer, 'takes_priors', False)


def model_parameters(
    model: Model, without_noise: str = 'estimated from the residual'
) -> tuple[ParameterSpec, ...]:
    """Return the parameters that the model's variables bring: bounds, fixed values, noise.

    `without_noise` says what is done where the noise is not given.
    """
    return (
        *(ParameterSpec(f'bounds.{v.name}', (v.lower, v.upper),
            f'lower and upper bound of {v.name}', v.unit, length=2)
          for v in model.variables),
        *(ParameterSpec(f'fixed.{v.name}', math.nan,
            f'holds {v.name} there, not estimated; nan: estimated, or its nominal value', v.unit,
            lower=-LARGEST, upper=LARGEST, nan=True)
          for v in model.variables),
        *(ParameterSpec(f'noise.{v.name}', 0.0,
            f'standard deviation of the measured {v.name}; 0: {without_noise}', v.unit,
            lower=0.0, upper=LARGEST)
          for v in model.outputs),
    )  # fmt: skip


def own_prefix(observer: str) -> str:
    """Return the prefix of the names of an observer's own parameters."""
    return f'{observer.rpartition(":")[2]}.'


def is_foreign(name: str) -> bool:
    """Whether every node has a parameter of that name, without declaring it."""
    return _FOREIGN.fullmatch(name) is not None
