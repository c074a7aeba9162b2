"""The estimator's parameters, and the observer that they describe."""

import math
from collections.abc import Mapping
from typing import Any, get_args

from obs_ros.core.model import Model
from obs_ros.core.parameter_spec import LARGEST_SEED, ParameterSpec, Value, markdown_table
from obs_ros.inference.objective import FITNESSES
from obs_ros.interface.usage import node_usage
from obs_ros.observers.base import OBSERVERS, Observer, load_observer
from obs_ros.observers.settings import parameter_specs
from obs_ros.optimization.differential_evolution import Strategy
from obs_ros.optimization.initial_population import POPULATIONS
from obs_ros.optimization.methods import METHODS
from obs_ros.samples.range_check import LARGEST

ALL, NONE = 'all', 'none'

MOST_STEPS = 1e7  # of the model, over a window and to the next: a second, of one candidate

# What parameters were called once, with what they are called now.
RENAMED = {'predict': 'prediction.enabled', 'predict.rate': 'prediction.rate'}

# They say what is loaded: a remote `param set` must never import code.
CHOICE = (
    ParameterSpec(
        'model', 'three_tank', 'plant model: a built-in name or package.module:ATTRIBUTE',
        read_only=True,
    ),
    ParameterSpec(
        'observer', 'sliding_window', 'observer: a built-in name or package.module:CLASS',
        read_only=True,
    ),
    ParameterSpec(
        'merge_wait', 0.1,
        'wall time that samples wait for older ones on other topics: where `signals` name several, '
        'and outputs for inputs that are due, 1 s at most',
        's', lower=0.0, upper=60.0, read_only=True,
    ),
)  # fmt: skip

# A change of these needs no new observer. Immediate observers need neither deadline nor prediction.
LIVE = (
    ParameterSpec('deadline', 1.0, 'wall time for one solve, best so far when it ends', 's',
        positive=True, upper=3600.0),
    ParameterSpec(
        'stale_after', 5.0, 'wall time without samples after which a stream is stale', 's',
        positive=True, upper=1e6,
    ),
    ParameterSpec(
        'prediction.enabled', True,
        'publish ~/prediction, the state carried on to the newest output',
    ),
    ParameterSpec(
        'prediction.rate', 0.0,
        'predictions per s of sample time at most; 0: one for every output', 'Hz', lower=0.0,
        upper=1e6,
    ),
)  # fmt: skip

COMMON = (
    ParameterSpec('window.duration', 1000.0, 'length of a window, in sample time', 's', lower=1e-3,
        upper=1e9),
    ParameterSpec(
        'window.period', 0.0, 'from one window to the next; 0: the duration, so they abut', 's',
        lower=0.0, upper=1e9,
    ),
    ParameterSpec(
        'window.capacity', 100000, 'samples of a stream kept at most; the oldest are dropped',
        lower=2, upper=1_000_000,
    ),
    ParameterSpec(
        'parameters', (ALL,),
        f"names of the parameters to estimate; ['{ALL}'] or ['{NONE}'] for all or none",
    ),
    ParameterSpec(
        'states', (ALL,),
        f"names of the initial states to estimate; ['{ALL}'] or ['{NONE}'] for all or none",
    ),
    ParameterSpec(
        'learn_noise', False,
        'the noise given is only where learning it from the windows begins; false: it is trusted',
    ),
    ParameterSpec(
        'fitness', FITNESSES[0], 'what the search compares windows by', choices=FITNESSES,
    ),
    ParameterSpec(
        'seed', 0, 'seed of the search; the same samples then give the same estimates', lower=0,
        upper=LARGEST_SEED,
    ),
    ParameterSpec('search.method', 'memetic', 'search method', choices=tuple(METHODS)),
    ParameterSpec(
        'search.chaos', '', "first population; '': the method's own", choices=('', *POPULATIONS),
    ),
    ParameterSpec(
        'search.population', 0, "candidates (Np); 0: the method's own", lower=0, upper=100_000,
    ),
    ParameterSpec(
        'search.generations', 0, "generations (Gm) at most; 0: the method's own", lower=0,
        upper=1_000_000,
    ),
    ParameterSpec(
        'search.strategy', '', "mutation and crossover; '': the method's own",
        choices=('', *get_args(Strategy)),
    ),
    ParameterSpec(
        'search.differential_weight', 0.0, "differential weight F; 0: the method's own",
        lower=0.0, upper=2.0,
    ),
    ParameterSpec(
        'search.crossover', 0.0, "crossover probability CR; 0: the method's own",
        lower=0.0, upper=1.0,
    ),
)  # fmt: skip


# What immediate observers share with those that solve windows.
SHARED = ('stale_after', 'parameters', 'states', 'seed')


def observer_parameters(model: Model, name: str) -> tuple[ParameterSpec, ...]:
    """Return the parameters that the observer of that name has on that model.

    Raises ValueError when there is no such observer.
    """
    observer: Any = load_observer(name)
    if not observer.immediate:
        start = 'in a start that the next window races against the others; nan: mid of bounds'
        return (*LIVE, *COMMON, *model_parameters(model), *initial_parameters(model, start))
    start = "at the start; nan: the observer's own, nominal or mid of bounds"
    return (
        *(spec for spec in (*LIVE, *COMMON) if spec.name in SHARED),
        *parameter_specs(observer.Settings, _prefix(name)),
        *model_parameters(model, "the observer's own"),
        *initial_parameters(model, start),
    )


def initial_parameters(model: Model, start: str) -> tuple[ParameterSpec, ...]:
    """Return the parameters that say where the estimates begin; `start` tells what that means."""
    return tuple(
        ParameterSpec(
            f'initial.{v.name}',
            math.nan,
            f'{v.name} {start}',
            v.unit,
            lower=-LARGEST,
            upper=LARGEST,
            nan=True,
        )
        for v in model.variables
    )


def usage() -> str:
    """Return what `estimator --help` prints."""
    return node_usage(
        'estimator',
        'Estimates states and parameters of a plant while it runs: from plant/output and '
        'plant/input, or what signals.* name, to ~/state, ~/parameters, ~/jump and /diagnostics.',
        (*CHOICE, *LIVE, *COMMON),
        {
            'bounds.NAME': '[lower, upper] of a state or parameter',
            'fixed.NAME': 'holds a state or parameter there; nan: it is estimated, or nominal',
            'initial.NAME': 'a start that the next window races against the others; nan: none',
            'noise.OUTPUT': 'standard deviation of a measured output; 0: estimated',
            'signals.NAME.topic, .type, .field, .scale, .offset, .stamp':
                'where an output or input comes from (at start only)',
        },
        (
            'Each with a comment: share/obs_ros/config/three_tank.yaml. Of other observers: '
            'docs/observer-parameters.md. A plant of your own: docs/your-own-plant.md.',
        ),
    )  # fmt: skip


def settings_page() -> str:
    """Return, in Markdown, the settings that each immediate observer has of its own."""
    parts = [
        '# Settings of the observers\n\n'
        'What each observer that goes sample by sample has besides the parameters that all share\n'
        '(`parameters`, `states`, `seed`, `bounds.<name>`, `fixed.<name>`, `noise.<output>`,\n'
        '`initial.<name>`, `stale_after`). [Which observer?](which-observer.md) says what each is '
        'for.\n\nThis page is made by `python -m obs_ros.interface.settings`.'
    ]
    for name in sorted(OBSERVERS):
        observer: Any = load_observer(name)
        if observer.immediate:
            rows = parameter_specs(observer.Settings, _prefix(name))
            parts.append(f'## {name}\n\n{markdown_table(rows).rstrip()}')
    return '\n\n'.join(parts) + '\n'


def model_parameters(
    model: Model, without_noise: str = 'estimated from the residual'
) -> tuple[ParameterSpec, ...]:
    """Return the parameters that the model's variables bring: bounds, fixed values, noise.

    `without_noise` says what is done where the noise is not given.
    """
    bounds = [
        ParameterSpec(
            f'bounds.{v.name}', (v.lower, v.upper), f'lower and upper bound of {v.name}', v.unit,
            length=2,
        )
        for v in model.variables
    ]  # fmt: skip
    fixed = [
        ParameterSpec(
            f'fixed.{v.name}', math.nan,
            f'holds {v.name} there, not estimated; nan: estimated, or its nominal value', v.unit,
            lower=-LARGEST, upper=LARGEST, nan=True,
        )
        for v in model.variables
    ]  # fmt: skip
    noise = [
        ParameterSpec(
            f'noise.{v.name}', 0.0,
            f'standard deviation of the measured {v.name}; 0: {without_noise}', v.unit, lower=0.0,
            upper=LARGEST,
        )
        for v in model.outputs
    ]  # fmt: skip
    return (*bounds, *fixed, *noise)


def build_observer(model: Model, values: Mapping[str, Any]) -> Observer:
    """Return a new observer of `model` for the parameter values.

    Raises ValueError for what single parameters could not tell, with the name and the value.
    """
    observer: Any = load_observer(values['observer'])
    common = {
        'parameters': _names(values['parameters']),
        'states': _names(values['states']),
        'bounds': {
            name: bounds
            for name, bounds in _under('bounds.', values).items()
            if bounds != (model.variable(name).lower, model.variable(name).upper)
        },
        'fixed': _given('fixed.', values),
        'noise': {
            name: deviation for name, deviation in _under('noise.', values).items() if deviation
        },
        'seed': values['seed'],
    }
    common['initial'] = _given('initial.', values)
    if observer.immediate:
        settings = _under(_prefix(values['observer']), values)
        immediate: Observer = observer(model, **common, **settings)
        return immediate
    _check_steps(model, values['window.duration'] + values['window.period'])
    windowed: Observer = observer(
        model,
        **common,
        duration=values['window.duration'],
        period=values['window.period'] or None,
        capacity=values['window.capacity'],
        search=values['search.method'],
        search_options={
            option: value
            for option, value in _under('search.', values).items()
            if option != 'method' and value
        },
        learn_noise=values['learn_noise'],
        fitness=values['fitness'],
    )
    return windowed


def _check_steps(model: Model, reach: float) -> None:
    """Raise ValueError where samples so far apart (s) would take the model too many steps.

    Nothing can interrupt the steps from one sample to the next.
    """
    if reach > MOST_STEPS * model.max_step:
        raise ValueError(
            f'shorten window.duration or window.period: {reach:g} s are '
            f'{reach / model.max_step:.2g} steps of model {model.name!r}, at most {MOST_STEPS:g}'
        )


def differs(values: Mapping[str, Value], from_values: Mapping[str, Value]) -> bool:
    """Say whether an observer for `values` is another one than for `from_values`."""
    live = {spec.name for spec in LIVE}
    # As dicts: they take a NaN for equal to itself.
    one, other = ({k: v for k, v in s.items() if k not in live} for s in (values, from_values))
    return one != other


def _under(prefix: str, values: Mapping[str, Any]) -> dict[str, Any]:
    return {name.removeprefix(prefix): v for name, v in values.items() if name.startswith(prefix)}


def _given(prefix: str, values: Mapping[str, Any]) -> dict[str, float]:
    return {name: v for name, v in _under(prefix, values).items() if not math.isnan(v)}


def _prefix(observer: str) -> str:
    """Return what the names of an observer's own settings begin with."""
    return f'{observer.rpartition(":")[2]}.'


def _names(names: tuple[str, ...]) -> tuple[str, ...] | None:
    return None if names == (ALL,) else () if names == (NONE,) else names


if __name__ == '__main__':
    print(settings_page(), end='')
