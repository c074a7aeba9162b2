"""Delays that are estimated: unknowns of a model beside the parameters that its functions take."""

import functools
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, TypeVar

Kind = TypeVar('Kind', bound=Any)
SUFFIX = '.delay'


def is_delay(name: str) -> bool:
    """Whether a parameter of that name is a delay: those of functions are called by identifiers."""
    return name.endswith(SUFFIX)


def signal_of(name: str) -> str:
    """Return the input or output whose delay a parameter of that name is."""
    return name.removesuffix(SUFFIX)


def own_parameters(parameters: Iterable[Kind]) -> tuple[Kind, ...]:
    """Return the parameters that the plant's functions take: all but delays, in their order."""
    return tuple(each for each in parameters if not is_delay(each.name))


def unknowns(
    signals: Iterable[Any], parameters: Iterable[Any], variable: type[Kind]
) -> tuple[Kind, ...]:
    """Return a variable for each delay to be estimated, with all that `parameters` know of it."""
    known = {each.name: each for each in parameters}
    found: list[Kind] = []
    for signal in signals:
        if isinstance(signal.delay, tuple):
            lower, upper = signal.delay
            name = f'{signal.name}{SUFFIX}'
            # Nothing is measured, or acts, before its time: zero is no guess.
            physical = 'lower' if lower == 0.0 else 'none'
            bounds = {'lower': lower, 'upper': upper, 'physical': physical}
            found.append(replace(known.get(name, variable(name, 's')), **bounds))
    return tuple(found)


def refuse(parameters: Iterable[str], observer: str) -> None:
    """Raise ValueError if one of the parameters is a delay: such an observer cannot find it."""
    for name in parameters:
        if is_delay(name):
            raise ValueError(
                f'give the delay of {signal_of(name)} as one number, or take the observer '
                f'sliding_window: {observer} estimates no delays'
            )


def plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function that `of_first` made another of, or the function itself."""
    found: Callable[..., Any] = getattr(function, 'takes_all_of', function)
    return found


@functools.lru_cache(maxsize=256)  # one object for one function, by which compiled code is known
def of_first(function: Callable[..., Any], count: int) -> Callable[..., Any]:
    """Return the plant's function f(t, x, u, p) as one of the first `count` entries of p."""

    def of_own_parameters(t: Any, x: Any, u: Any, p: Any) -> Any:
        return function(t, x, u, p[:count])

    of_own_parameters.takes_all_of = function  # type: ignore[attr-defined]
    return of_own_parameters
