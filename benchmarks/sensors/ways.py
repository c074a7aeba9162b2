"""One plant, its functions written in all the ways that people write them.

A mass on a spring that hardens, behind a force that saturates, in coordinates of two sensors.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.sensors import ways_helpers
from obs_ros import Model, Variable

LEVER = np.array([[1.0, 0.25], [0.5, 1.0]])  # from states to outputs
TORQUE, REACH = 4.0, 2.0  # N, and m beyond which the spring pulls no harder

Function = Callable[[Any, Any, Any, Any], Any]


def dynamics(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the rates as documented: a tuple, NumPy's functions."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]


def output(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the outputs as documented."""
    return x[0] + 0.25 * x[1], 0.5 * x[0] + x[1]


def listed(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return a list."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    return [x[1], force - p[0] * np.sin(pull) - p[1] * x[1]]


def arrayed(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return an array."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    return np.array([x[1], force - p[0] * np.sin(pull) - p[1] * x[1]])


def stacked(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Stack numbers."""
    return np.stack(dynamics(t, x, u, p))


def joined(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Join slices."""
    return np.concatenate([x[1:], dynamics(t, x, u, p)[1:]])


def filled(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Fill an array."""
    rates = np.zeros(2)
    rates[0] = x[1]
    rates[1:] = dynamics(t, x, u, p)[1:]
    return rates


def clipped(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Limit by np.clip."""
    pull, force = np.clip(x[0], -REACH, REACH), np.clip(u[0], -TORQUE, TORQUE)
    return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]


def dotted(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Multiply by np.dot."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    return x[1], force - np.dot(p, [np.sin(pull), x[1]])


def with_matrix(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Multiply by a matrix of parameters."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    A = np.array([[0.0, 1.0], [-p[0], -p[1]]])
    rates = A @ np.array([np.sin(pull), x[1]])
    return rates[0], rates[1] + force


def with_math(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Take the sine of `math`."""
    pull = np.minimum(np.maximum(x[0], -REACH), REACH)
    force = np.minimum(np.maximum(u[0], -TORQUE), TORQUE)
    return x[1], force - p[0] * math.sin(pull) - p[1] * x[1]


def with_builtins(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Limit by the built-in min and max, add by sum, and take abs."""
    size = min(abs(x[0]), REACH)
    pull = np.sign(x[0]) * size
    force = min(max(u[0], -TORQUE), TORQUE)
    return x[1], sum([force, -p[0] * np.sin(pull), -p[1] * x[1]])


def with_branches(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Branch on values."""
    pull, force = x[0], u[0]
    if pull > REACH:
        pull = REACH
    elif pull < -REACH:
        pull = -REACH
    if abs(force) > TORQUE:
        force = np.sign(force) * TORQUE
    return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]


def with_loops(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Loop over tuples."""
    limits = []
    for value, most in zip((x[0], u[0]), (REACH, TORQUE), strict=True):
        limits.append(np.minimum(np.maximum(value, -most), most))
    rate = limits[1]
    for gain, of in zip(p, (np.sin(limits[0]), x[1]), strict=True):
        rate -= gain * of
    return x[1], rate


def with_vectors(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Compute with whole vectors."""
    most = np.array([REACH, TORQUE])
    pull, force = np.clip(np.array([x[0], u[0]]), -most, most)
    losses = p * np.array([np.sin(pull), x[1]])
    return np.hstack([x[1], force - losses.sum()])


def with_helpers(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Call helpers of another module."""
    return x[1], ways_helpers.limited(u[0], TORQUE) - ways_helpers.pull(x, p, REACH)


def seen_through_matrix(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the outputs as a constant matrix times the states."""
    return LEVER @ np.array([x[0], x[1]])


class Mass:
    """A mass whose limits are attributes; a bound method of it is a model's function."""

    def __init__(self, torque: float, reach: float) -> None:
        self.torque, self.reach = torque, reach

    def rates(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        """Return the rates."""
        pull = np.minimum(np.maximum(x[0], -self.reach), self.reach)
        force = np.minimum(np.maximum(u[0], -self.torque), self.torque)
        return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]

    def __call__(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        """Return the rates, as a callable object."""
        pull = np.minimum(np.maximum(x[0], -self.reach), self.reach)
        force = np.minimum(np.maximum(u[0], -self.torque), self.torque)
        return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]


def limited(torque: float, reach: float, t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return the rates; the limits are given by functools.partial."""
    pull = np.minimum(np.maximum(x[0], -reach), reach)
    force = np.minimum(np.maximum(u[0], -torque), torque)
    return x[1], force - p[0] * np.sin(pull) - p[1] * x[1]


def swapped(x: Any, t: Any, u: Any, p: Any) -> Any:
    """Take the arguments in a wrong order, x before t."""
    return x[1], u[0] - p[0] * np.sin(x[0]) - p[1] * x[1]


PLAIN = 'a tuple, NumPy'
WAYS: dict[str, tuple[Function, Function]] = {
    PLAIN: (dynamics, output),
    'a list': (listed, output),
    'an array': (arrayed, output),
    'np.stack': (stacked, output),
    'np.concatenate, slices': (joined, output),
    'np.zeros, filled': (filled, output),
    'np.clip': (clipped, output),
    'np.dot': (dotted, output),
    'A @ x with parameters': (with_matrix, output),
    'A @ x in the output': (dynamics, seen_through_matrix),
    'math.sin': (with_math, output),
    'min, max, abs, sum': (with_builtins, output),
    'if and else': (with_branches, output),
    'loops': (with_loops, output),
    'whole vectors': (with_vectors, output),
    'a lambda': (lambda t, x, u, p: list(dynamics(t, x, u, p)), output),
    'a bound method': (Mass(TORQUE, REACH).rates, output),
    'a callable object': (Mass(TORQUE, REACH), output),
    'functools.partial': (functools.partial(limited, TORQUE, REACH), output),
    'helpers of another module': (with_helpers, output),
}


def model(way: str) -> Model:
    """Return the plant with its functions written in a way."""
    rates, seen = WAYS[way]
    return built(rates, seen)


def built(rates: Function, seen: Function) -> Model:
    """Return the plant with these functions."""
    return Model(
        name='ways_of_writing',
        states=(Variable('place', 'm', lower=-4, upper=4), Variable('speed', 'm/s', -10, 10)),
        inputs=(Variable('force', 'N'),),
        outputs=(Variable('front', 'm'), Variable('rear', 'm')),
        parameters=(
            Variable('stiffness', 'N/m', lower=1, upper=30),
            Variable('friction', 'N s/m', lower=0, upper=5),
        ),
        dynamics=rates,
        output=seen,
        max_step=0.02,
    )
