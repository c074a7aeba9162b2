"""The search methods, by name: each minimises the costs of a `Problem` over the unit box."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, NamedTuple, Protocol

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.core.typing import Array
from obs_ros.optimization.chaotic_de import ChaoticDESettings, chaotic_de_search
from obs_ros.optimization.ga import GASettings, ga_search
from obs_ros.optimization.memetic import MemeticSettings, memetic_search
from obs_ros.optimization.problem import Problem
from obs_ros.optimization.result import Found


class Search(Protocol):
    """A function that looks for the point of the least cost until the deadline."""

    def __call__(
        self,
        problem: Problem,
        rng: np.random.Generator,
        deadline: Deadline,
        settings: Any,
        warm: Array | None = None,
        noise_known: bool = False,
        /,
    ) -> Found:
        """Search with `settings` of the method's own type.

        `warm` (d,) is a point to start from; with `noise_known` the residuals have unit variance.
        """


class Method(NamedTuple):
    """A search method: its function, its frozen dataclass of settings, and what it needs.

    With `needs_squares` it is given only problems that are least squares, and what it finds gets
    standard deviations and, in the window observer, a prior and jumps.
    """

    search: Search
    settings: type[Any]
    needs_squares: bool


METHODS: Mapping[str, Method] = {
    'memetic': Method(memetic_search, MemeticSettings, needs_squares=True),
    'chaotic_de': Method(chaotic_de_search, ChaoticDESettings, needs_squares=False),
    'ga': Method(ga_search, GASettings, needs_squares=False),
}


def method_for(name: str | Method, options: Mapping[str, Any] | None = None) -> tuple[Method, Any]:
    """Return a method, by name or as it is, and its settings, with some of them replaced.

    Raises ValueError for an unknown method, an unknown option or a value that it refuses.
    """
    if isinstance(name, str) and name not in METHODS:
        raise ValueError(f'unknown search method {quoted(name)}: {suggest(name, METHODS)}')
    method = METHODS[name] if isinstance(name, str) else name
    known = tuple(field.name for field in fields(method.settings))
    for option in options or {}:
        if option not in known:
            raise ValueError(
                f'search {quoted(name)} has no option {quoted(option)}: {suggest(option, known)}'
            )
    return method, method.settings(**(options or {}))
