"""One plant, written as people write theirs: two driven pendulums, joined by a spring."""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.writings import helpers
from obs_ros import Model, Variable

B = np.array([0.0, 0.0, 1.0, 0.0])
PICK = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
EXCHANGE = np.array([[-1.0, 1.0], [1.0, -1.0]])


def scalars(t: Any, x: Any, u: Any, p: Any) -> Any:
    """The plant in scalars, and a tuple returned: the way that compiles as it stands."""
    a, b, va, vb = x
    k, s, c = p
    force = np.clip(u[0], -2.0, 2.0)
    fa = np.maximum(np.abs(va) - 0.1, 0.0) * np.tanh(va)
    fb = np.maximum(np.abs(vb) - 0.1, 0.0) * np.tanh(vb)
    return (
        va,
        vb,
        force - (k + s) * a + s * b - c * va - 3.0 * np.sin(a) - fa,
        s * a - (k + s) * b - c * vb - 3.0 * np.sin(b) - fb,
    )


def measured(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return both angles."""
    return x[0], x[1]


def returns_a_list(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return a list."""
    return list(scalars(t, x, u, p))


def returns_an_array(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Return an array."""
    return np.array(scalars(t, x, u, p))


def stacks(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Stack numbers."""
    return np.stack(scalars(t, x, u, p))


def concatenates(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Join slices."""
    return np.concatenate([x[2:], scalars(t, x, u, p)[2:]])


def fills_zeros(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Fill an array."""
    dx = np.zeros(4)
    dx[:2] = x[2:]
    dx[2:] = scalars(t, x, u, p)[2:]
    return dx


def matrix_of_constants(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Multiply by matrices of constants."""
    exchange = p[1] * (EXCHANGE @ x[:2])
    rest = np.array([[p[0], 0.0], [0.0, p[0]]]) @ x[:2] + p[2] * np.array(x[2:])
    push = B[2:] * np.clip(u[0], -2.0, 2.0)
    own = np.array([3.0 * np.sin(x[i]) + helpers.sliding(x[2 + i]) for i in range(2)])
    return np.concatenate([x[2:], push + exchange - rest - own])


def matrix_of_parameters(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Multiply by a matrix that parameters make up."""
    k, s, c = p
    A = np.array(
        [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [-(k + s), s, -c, 0.0],
            [s, -(k + s), 0.0, -c],
        ]
    )
    own = [3.0 * np.sin(x[i]) + helpers.sliding(x[2 + i]) for i in range(2)]
    return A @ x + B * np.clip(u[0], -2.0, 2.0) - np.array([0.0, 0.0, *own])


def dot_products(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Use np.dot."""
    k, s, c = p
    own = [3.0 * np.sin(x[i]) + helpers.sliding(x[2 + i]) for i in range(2)]
    first = np.dot([-(k + s), s, -c], [x[0], x[1], x[2]])
    second = np.dot([s, -(k + s), -c], [x[0], x[1], x[3]])
    return x[2], x[3], np.clip(u[0], -2.0, 2.0) + first - own[0], second - own[1]


def maths(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Use math and Python's own functions."""
    a, b, va, vb = x
    k, s, c = p
    force = max(-2.0, min(2.0, u[0]))
    fa = max(abs(va) - 0.1, 0.0) * math.tanh(va)
    fb = max(abs(vb) - 0.1, 0.0) * math.tanh(vb)
    return (
        va,
        vb,
        sum([force, -(k + s) * a, s * b, -c * va, -3.0 * math.sin(a), -fa]),
        sum([s * a, -(k + s) * b, -c * vb, -3.0 * math.sin(b), -fb]),
    )


def loops(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Loop over tuples, with helpers of another module."""
    k, s, c = p
    rates = []
    for i, (angle, speed) in enumerate(zip(x[:2], x[2:], strict=True)):
        force = s * (x[1 - i] - angle) - k * angle - c * speed - helpers.pull(angle)
        if i == 0:
            force += np.clip(u[0], -2.0, 2.0)
        rates.append(force - helpers.sliding(speed))
    return *x[2:], *rates


def branches(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Branch on values."""
    k, s, c = p
    force = u[0]
    if force > 2.0:
        force = 2.0
    elif force < -2.0:
        force = -2.0
    rates = []
    for i in range(2):
        speed = abs(x[2 + i])
        slides = speed - 0.1 if speed > 0.1 else 0.0
        own = 3.0 * np.sin(x[i]) + slides * np.tanh(x[2 + i])
        rates.append(s * (x[1 - i] - x[i]) - k * x[i] - c * x[2 + i] - own)
    return [x[2], x[3], rates[0] + force, rates[1]]


def vectors(t: Any, x: Any, u: Any, p: Any) -> Any:
    """Compute with whole vectors."""
    angles, speeds = x[:2], x[2:]
    own = 3.0 * np.sin(angles) + np.maximum(np.abs(speeds) - 0.1, 0.0) * np.tanh(speeds)
    push = np.array([np.clip(u[0], -2.0, 2.0), 0.0])
    joined = p[1] * (angles[::-1] - angles)
    return np.hstack([speeds, push + joined - p[0] * angles - p[2] * speeds - own])


class Pendulums:
    """Two pendulums as an object."""

    def __init__(self, gravity: float, limit: float) -> None:
        self.gravity = gravity
        self.limit = limit
        self.from_speeds = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])

    def force(self, value: Any) -> Any:
        return np.clip(value, -self.limit, self.limit)

    def own(self, angle: Any, speed: Any) -> Any:
        return self.gravity * math.sin(angle) + max(abs(speed) - 0.1, 0.0) * math.tanh(speed)

    def dynamics(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        k, s, c = p
        a, b, va, vb = x
        first = self.force(u[0]) - (k + s) * a + s * b - c * va - self.own(a, va)
        second = s * a - (k + s) * b - c * vb - self.own(b, vb)
        return np.append(self.from_speeds @ x, [first, second])

    __call__ = dynamics


def scaled(gravity: float, limit: float, t: Any, x: Any, u: Any, p: Any) -> Any:
    """Make an object at each call, of constants that are bound."""
    return Pendulums(gravity, limit).dynamics(t, x, u, p)


WRITINGS: dict[str, Callable[..., Any]] = {
    'list returned': returns_a_list,
    'np.array returned': returns_an_array,
    'np.stack': stacks,
    'np.concatenate, slices': concatenates,
    'np.zeros, filled': fills_zeros,
    'A @ x, constants': matrix_of_constants,
    'A @ x, parameters': matrix_of_parameters,
    'np.dot': dot_products,
    'math, min, max, abs, sum': maths,
    'loops, helpers of another module': loops,
    'if and else': branches,
    'whole vectors': vectors,
    'bound method': Pendulums(3.0, 2.0).dynamics,
    'callable object': Pendulums(3.0, 2.0),
    'functools.partial': functools.partial(scaled, 3.0, 2.0),
    'lambda': lambda t, x, u, p: list(scalars(t, x, u, p)),
}


def pendulums(dynamics: Callable[..., Any], output: Callable[..., Any] = measured) -> Model:
    """Two pendulums whose dynamics are written so."""
    return Model(
        name='pendulums',
        states=(
            Variable('a', 'rad', -2, 2),
            Variable('b', 'rad', -2, 2),
            Variable('va', 'rad/s', -3, 3),
            Variable('vb', 'rad/s', -3, 3),
        ),
        inputs=(Variable('torque', '1/s2', nominal=0.0),),
        outputs=(Variable('a', 'rad'), Variable('b', 'rad')),
        parameters=(
            Variable('k', '1/s2', 1, 9),
            Variable('s', '1/s2', 0.1, 5),
            Variable('c', '1/s', 0, 1),
        ),
        dynamics=dynamics,
        output=output,
        max_step=0.02,
    )
