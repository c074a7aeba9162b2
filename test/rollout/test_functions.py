"""Tests of obs_ros.rollout.functions."""

import os
import subprocess
import sys
from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest

from obs_ros.rollout.functions import fingerprint, rebuilt

SOURCE = """
import numpy as np
GAIN = 2.0
TABLE = np.array([1.0, 2.0])
PAIR = (1, 2.0)
UNUSED = 0

def inner(x):
    return x + 1.0

def helper(x):
    return inner(x) * 3.0

def closure(k):
    def f(t, x, u, p, bias=0.5):
        return GAIN * helper(x) + k + TABLE[0] + PAIR[1] + np.sqrt(x) + bias
    return f

f = closure(7.0)
"""


def compiled(source: str) -> Callable[..., Any]:
    scope: dict[str, Any] = {}
    exec(source, scope)
    return scope['f']


def hashed(source: str) -> str:
    return fingerprint('', compiled(source))


def test_the_same_code_has_the_same_fingerprint_wherever_it_stands() -> None:
    assert hashed(SOURCE) == hashed(SOURCE) == hashed('\n\n# moved\n' + SOURCE)
    assert len(hashed(SOURCE)) == 24


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('GAIN = 2.0', 'GAIN = 2.1'),
        ('GAIN = 2.0', 'GAIN = 2'),
        ('TABLE = np.array([1.0, 2.0])', 'TABLE = np.array([1.0, 2.5])'),
        ('TABLE = np.array([1.0, 2.0])', 'TABLE = np.array([[1.0, 2.0]])'),
        ('PAIR = (1, 2.0)', 'PAIR = (1, 3.0)'),
        ('x + 1.0', 'x + 1.5'),
        ('x + 1.0', 'x - 1.0'),
        ('inner(x) * 3.0', 'inner(x) * 4.0'),
        ('closure(7.0)', 'closure(8.0)'),
        ('bias=0.5', 'bias=0.6'),
        ('np.sqrt', 'np.exp'),
        ('GAIN * helper', 'GAIN + helper'),
    ],
)
def test_whatever_the_result_depends_on_changes_it(old: str, new: str) -> None:
    assert old in SOURCE
    assert hashed(SOURCE) != hashed(SOURCE.replace(old, new))


def test_what_is_not_used_does_not_change_it() -> None:
    assert hashed(SOURCE) == hashed(SOURCE.replace('UNUSED = 0', 'UNUSED = 1'))


def test_constants_and_helpers_of_another_module_count() -> None:
    other = ModuleType('other')
    other.__dict__.update(GAIN=1.0, UNUSED=1.0, helper=lambda x: 2.0 * x)

    def f(x: float) -> float:
        return float(other.GAIN * other.helper(x))

    prints = [fingerprint('', f)]
    for name, new in (('GAIN', 2.0), ('helper', lambda x: 3.0 * x)):
        setattr(other, name, new)
        prints.append(fingerprint('', f))
    assert len(set(prints)) == 3
    other.__dict__['UNUSED'] = 2.0
    assert fingerprint('', f) == prints[-1]


IMPORTED = """
from numpy import where
from obs_ros.rollout.functions import fingerprint

def f(t, x, u, p):
    return (where(x[0] > 0, 1.0, 0.0),)

print(fingerprint('', f))
"""


def test_numpy_functions_imported_by_name_hash_alike_in_every_process() -> None:
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    prints = {
        subprocess.run(
            [sys.executable, '-c', IMPORTED],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    }
    assert len(prints) == 1


def test_text_and_order_of_functions_count() -> None:
    def f(x: float) -> float:
        return x + 1.0

    def g(x: float) -> float:
        return x + 2.0

    assert fingerprint('a', f) != fingerprint('b', f)
    assert fingerprint('', f, g) != fingerprint('', g, f)


def test_a_function_that_calls_itself_has_a_fingerprint() -> None:
    def f(x: float) -> float:
        return x if x < 1.0 else f(x - 1.0)

    assert fingerprint('', f) == fingerprint('', f)


def test_rebuilt_replaces_helpers_at_every_depth_and_keeps_the_result() -> None:
    seen: list[str] = []

    def convert(function: FunctionType) -> Callable[..., Any]:
        seen.append(function.__name__)
        return lambda *args: function(*args)

    original = compiled(SOURCE)
    copy = rebuilt(original, convert)
    assert seen == ['inner', 'helper']
    assert copy is not original
    assert copy(0.0, 4.0, (), ()) == original(0.0, 4.0, (), ())
    assert original.__globals__['helper'].__name__ == 'helper'


def test_rebuilt_replaces_helpers_in_closures_and_keeps_defaults() -> None:
    def helper(x: float) -> float:
        return 2.0 * x

    def f(x: float, /, a: float = 3.0, *, b: float = 4.0) -> float:
        return helper(x) + a + b

    copy = rebuilt(f, lambda function: lambda x: function(x) + 100.0)
    assert (f(1.0), copy(1.0), copy(1.0, b=0.0)) == (9.0, 109.0, 105.0)
    assert (copy.__name__, copy.__module__) == ('f', __name__)


@pytest.mark.parametrize('thing', [np.sin, len, 3.0])
def test_something_else_than_a_function_is_refused(thing: Any) -> None:
    with pytest.raises(ValueError, match='is not a plain Python function'):
        rebuilt(thing, lambda function: function)


def test_rebuilt_leaves_functions_of_libraries_alone() -> None:
    isscalar = np.isscalar
    assert isinstance(isscalar, FunctionType)  # plain Python, as ever fewer of NumPy's

    def f(x: float) -> bool:
        return bool(isscalar(x))

    assert rebuilt(f, lambda function: pytest.fail(f'{function} is converted'))(3.0)


def test_rebuilt_refuses_a_function_that_calls_itself_directly_or_not() -> None:
    def down(x: float) -> float:
        return x if x < 1.0 else down(x - 1.0)

    def f(x: float) -> float:
        return down(x)

    for function in (down, f):
        with pytest.raises(ValueError, match=r'down calls itself'):
            rebuilt(function, lambda function: function)
