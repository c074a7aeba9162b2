"""Walks and priors of a model's variables: given by the user in place of the model's own."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from obs_ros.core.model import Model
from obs_ros.core.texts import quoted


def with_knowledge(
    model: Model,
    walks: Mapping[str, float] | None = None,
    priors: Mapping[str, tuple[float, float] | None] | None = None,
) -> Model:
    """Return the model whose states and parameters of these names have these walks and priors.

    A walk of 0 and a prior None take the model's own away. Raises ValueError for an unknown name,
    and as `Variable` does for a walk or a prior that cannot be one.
    """
    for kind, given in (('walks', walks), ('priors', priors)):
        if given is not None and not isinstance(given, Mapping):
            raise ValueError(f'{kind} must be given by name, not as {quoted(given)}')
        for name in given or {}:
            model.variable(name)
    changes: dict[str, dict[str, Any]] = {}
    for name, walk in (walks or {}).items():
        changes[name] = {'walk': walk if walk else None}
    for name, prior in (priors or {}).items():
        changes[name] = {**changes.get(name, {}), 'prior': prior}
    if not changes:
        return model
    return replace(
        model,
        states=[replace(v, **changes.get(v.name, {})) for v in model.states],
        parameters=[replace(v, **changes.get(v.name, {})) for v in model.parameters],
    )


def without_knowledge(model: Model) -> Model:
    """Return the model without walks, priors and `max_step`, on which no compiled code depends."""
    plain = with_knowledge(
        model,
        {v.name: 0.0 for v in model.variables if v.walk is not None},
        {v.name: None for v in model.variables if v.prior is not None},
    )
    if plain.period is not None or math.isinf(plain.max_step):
        return plain
    return replace(plain, max_step=math.inf)
