"""Minimise over a box. Nothing here knows plants or ROS.

A method is a function `(objective, rng, deadline, settings, warm, noise_known) -> Found` with a
frozen dataclass of settings.
"""

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, NamedTuple

from obs_ros.core.registry import suggest
from obs_ros.core.texts import quoted
from obs_ros.optimization.chaotic_de import ChaoticDESettings, chaotic_de_search
from obs_ros.optimization.ga import GASettings, ga_search
from obs_ros.optimization.memetic import MemeticSettings, memetic_search
from obs_ros.optimization.result import Found


class Method(NamedTuple):
    """A search method: its function, its settings, whether it needs a sum of squares."""

    search: Callable[..., Found]
    settings: type
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
