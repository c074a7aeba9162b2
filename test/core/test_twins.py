"""Tests of obs_ros.core.twins: objects whose methods see the substitutes."""

import math
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from obs_ros.core.tracing import traced
from obs_ros.core.twins import Twins


class Base:
    limit = 2.0

    def saturated(self, x: Any) -> Any:
        return max(-self.limit, min(self.limit, x))


@dataclass(frozen=True)
class Gains:
    a: float
    b: float

    @property
    def both(self) -> float:
        return self.a * self.b

    def wave(self, x: Any) -> Any:
        return self.both * math.sin(x)


class Plant(Base):
    def __init__(self) -> None:
        self.gains = Gains(2.0, 3.0)
        self.own = self
        self.table = SimpleNamespace(square=lambda x: math.pow(x, 2))

    @staticmethod
    def decay(x: Any) -> Any:
        return math.exp(-x)

    def dynamics(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        fresh = Gains(1.0, 2.0)
        return [
            self.gains.wave(x[0]) + self.own.decay(x[0]),
            super().saturated(x[0]) + self.saturated(x[0]) + fresh.wave(x[0]),
        ]

    def __call__(self, t: Any, x: Any, u: Any, p: Any) -> Any:
        return self.dynamics(t, x, u, p)


def factorial(n: int) -> int:
    return 1 if n == 0 else n * factorial(n - 1)


X = np.linspace(-3.0, 3.0, 20)


def same(function: Any) -> None:
    found = traced(function, (1, 0, 0), 2, tuple)(0.0, (X,), (), ())
    expected = np.array([function(0.0, (x,), (), ()) for x in X.tolist()])
    np.testing.assert_allclose(np.array(found).T, expected, rtol=1e-12)


def test_methods_objects_and_partial_functions_are_recorded() -> None:
    plant = Plant()
    same(plant.dynamics)
    same(plant)
    same(partial(plant.dynamics))
    same(partial(lambda k, t, x, u, p, *, b: [k.wave(x[0]), b * math.cos(x[0])], plant.gains, b=2))


def test_the_object_itself_stays_as_it_is() -> None:
    plant = Plant()
    twin = Twins().twin(plant)
    assert twin is not plant and isinstance(twin, Plant) and type(plant) is Plant
    assert type(plant.gains) is Gains and twin.own is twin
    assert plant.dynamics(0.0, (1.0,), (), ()) == twin.dynamics(0.0, (1.0,), (), ())


def test_a_function_may_call_itself() -> None:
    same(lambda t, x, u, p: (factorial(4) * x[0], math.sin(x[0])))


def test_numbers_and_arrays_have_no_twin() -> None:
    array = np.zeros(3)
    assert Twins().twin(array) is array
    assert Twins().twin('text') == 'text'
