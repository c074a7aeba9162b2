"""The observer that the values of a node's parameters describe."""

import math
from collections.abc import Mapping
from typing import Any

from obs_ros.core.model import Model
from obs_ros.core.parameter_spec import Value
from obs_ros.interface.parameters import ALL, LIVE, NONE, NOTHING, own_prefix, takes_priors
from obs_ros.observers.base import Observer, load_observer
from obs_ros.samples.at_nodes import MOST_NODES

MOST_STEPS = 1e7  # of the model, over a window and to the next: a second, for one candidate


def build_observer(model: Model, values: Mapping[str, Any]) -> Observer:
    """Return a new observer of `model` for the parameter values.

    Raises ValueError, with name and value, for parameters that do not go together.
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
        'initial': _given('initial.', values),
        'seed': values['seed'],
    }
    if takes_priors(observer):
        common |= _knowledge(model, values)
    if observer.immediate:
        settings = _under(own_prefix(values['observer']), values)
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
        process_noise=values['process_noise'],
        loss=values['loss'],
        fitness=values['fitness'],
    )
    return windowed


def _knowledge(model: Model, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return walks and priors that are not the model's."""
    walks, priors = _under('walk.', values), _under('prior.', values)
    return {
        'walks': {
            name: walk for name, walk in walks.items() if walk != (model.variable(name).walk or 0.0)
        },
        'priors': {
            name: None if prior == NOTHING else prior
            for name, prior in priors.items()
            if prior != (model.variable(name).prior or NOTHING)
        },
    }


def _check_steps(model: Model, reach: float) -> None:
    """Raise ValueError where samples so far apart (s) would take the model too many steps.

    Nothing can interrupt the steps from one sample to the next.
    """
    most = MOST_STEPS if model.period is None else MOST_NODES
    if reach > most * model.max_step:
        raise ValueError(
            f'shorten window.duration or window.period: {reach:g} s are '
            f'{reach / model.max_step:.2g} steps of model {model.name!r}, at most {most:g}'
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


def _names(names: tuple[str, ...]) -> tuple[str, ...] | None:
    return None if names == (ALL,) else () if names == (NONE,) else names
