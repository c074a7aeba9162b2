"""Variants of a set of parameters: every combination of the values to vary."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from obs_ros.core.parameter_spec import Value
from obs_ros.core.texts import quoted
from obs_ros.interface.settings import build_observer
from obs_ros.replay.parameter_file import parse
from obs_ros.replay.settings import Setup, setup

MOST_VARIANTS = 1000  # more of them nobody compares, and a picture of them nobody reads
AS_GIVEN = 'as given'


@dataclass(frozen=True)
class Variant:
    """Values of the parameters that vary, all parameters as given, and the node's setup of them."""

    varied: Mapping[str, Value]
    given: Mapping[str, Any]
    setup: Setup

    def __str__(self) -> str:
        """Name the values, as in `window.duration=100, process_noise=off`."""
        return ', '.join(f'{n}={shown(v)}' for n, v in self.varied.items()) or AS_GIVEN


def variants(given: Mapping[str, Any], asked: Sequence[str]) -> list[Variant]:
    """Return the variants of the parameters `given`, in the order of the values `asked` for.

    Each entry of `asked` is `name=a,b`; the last one varies fastest. Raises ValueError for what is
    of another form, a parameter that there is not, a value that is wrong or there twice, and for
    parameters that do not go together.
    """
    axes = dict(axis(text) for text in asked)
    if len(axes) < len(asked):
        raise ValueError('--vary: give all values of a parameter at once, as in name=a,b')
    if (count := math.prod(map(len, axes.values()))) > MOST_VARIANTS:
        raise ValueError(f'--vary: {count} variants, of at most {MOST_VARIANTS}')
    found: list[Variant] = []
    for values in itertools.product(*axes.values()):
        own = {**given, **dict(zip(axes, values, strict=True))}
        chosen = setup(own)
        for name in axes:
            if name not in chosen.values:
                raise ValueError(f'--vary: there is no parameter {quoted(name)}')
        build_observer(chosen.model, chosen.values)  # what does not go together is told at once
        varied = {name: chosen.values[name] for name in axes}
        if any(varied == other.varied for other in found):
            raise ValueError(f'--vary: {Variant(varied, own, chosen)} is there twice')
        found.append(Variant(varied, own, chosen))
    return found


def axis(text: str) -> tuple[str, list[Any]]:
    """Return name and values of `name=a,b`, values as in a parameter file.

    Raises ValueError for anything else.
    """
    name, separator, values = text.partition('=')
    name = name.removesuffix(':')  # as after -p
    if not (name and separator and values.strip()):
        raise ValueError(f'--vary {quoted(text)} is not of the form NAME=A,B')
    return name, list(parse(f'[{values}]'.encode(), f'--vary {name}'))


def shown(value: Value) -> str:
    """Return a value as on the command line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f'[{", ".join(map(shown, value))}]'
    return f'{value:g}' if isinstance(value, float) else str(value)
