"""The kind of a model, continuous or discrete in time, and what goes with it: checked."""

import math
from collections.abc import Iterable, Sequence
from typing import Any, Literal, get_args

from obs_ros.core.variable_fields import number

Kind = Literal['continuous', 'discrete']
DISCRETE = 'discrete'  # the method of discrete models as well
# Today's stamps as floats resolve 0.24 us: a tenth of a period must stay well above.
PERIODS = 1e-5, 1e9  # s


def check_stepping(
    name: str, kind: str, period: object, integrator: str, max_step: object, methods: Iterable[str]
) -> tuple[float | None, str, float]:
    """Return period (s), integrator and longest step (s) of a model of that kind.

    A discrete model's step is its period, and its method `discrete`; neither is to be chosen.
    `methods` are the integrators that there are. Raises ValueError for what does not go together.
    """
    what = f'model {name!r}'
    longest = number(f'{what}: max_step', max_step)
    if not longest > 0:
        raise ValueError(f'{what}: max_step {longest} s is not positive')
    if kind not in get_args(Kind):
        raise ValueError(f'{what}: kind {kind!r} is none of {", ".join(get_args(Kind))}')
    if kind == DISCRETE:
        return _discrete(what, period, integrator, longest)
    if period is not None:
        raise ValueError(
            f"{what}: leave out period, or say kind='discrete' where dynamics gives the next "
            f'state; period is {period!r}'
        )
    known = [method for method in methods if method != DISCRETE]
    if integrator == DISCRETE:
        raise ValueError(f"{what}: say kind='discrete' and the period, not integrator 'discrete'")
    if integrator not in known:
        raise ValueError(f'{what}: integrator {integrator!r} is none of {", ".join(known)}')
    return None, integrator, longest


def _discrete(
    what: str, period: object, integrator: str, max_step: float
) -> tuple[float, str, float]:
    if period is None:
        raise ValueError(f'{what}: give a discrete model its period, in s from node to node')
    length = number(f'{what}: period', period)
    if not PERIODS[0] <= length <= PERIODS[1]:
        raise ValueError(
            f'{what}: period {length} s is not within {PERIODS[0]:g} to {PERIODS[1]:g} s'
        )
    if max_step not in (math.inf, length):
        raise ValueError(
            f'{what}: leave out max_step, as the step of a discrete model is its period, '
            f'{length:g} s; max_step is {max_step:g} s'
        )
    if integrator not in ('auto', DISCRETE):
        raise ValueError(
            f'{what}: leave out integrator, as a discrete model has no rates to integrate; '
            f'it is {integrator!r}'
        )
    return length, DISCRETE, length


def check_signals(name: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> None:
    """Raise ValueError for an input or output that a discrete model cannot have."""
    for variable in inputs:
        if variable.interpolation != 'hold':
            raise ValueError(
                f"model {name!r}: let input {variable.name} have interpolation 'hold': a discrete "
                f'model takes the input in force at each node, not one that is '
                f'{variable.interpolation!r} in between'
            )
    for variable in (*inputs, *outputs):
        if isinstance(variable.delay, tuple):
            raise ValueError(
                f'model {name!r}: give the delay of {variable.name} as one number: within '
                f'{variable.delay[0]:g} to {variable.delay[1]:g} s it would be estimated, which '
                'takes a plant between the nodes, and a discrete model has none'
            )
