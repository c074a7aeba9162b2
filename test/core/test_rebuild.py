"""Tests of obs_ros.core.rebuild."""

from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
import pytest
from numpy import where, zeros

from obs_ros.core.rebuild import Rebuilder


def rebuilt(function: Any, convert: Callable[..., Any]) -> FunctionType:
    return Rebuilder(convert, 'elsewhere').copy(function)


TABLE = np.array([0.0, 1.0])

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


def test_rebuilt_replaces_helpers_at_every_depth_and_keeps_the_result() -> None:
    seen: list[str] = []

    def convert(function: FunctionType) -> Callable[..., Any]:
        seen.append(function.__name__)
        return lambda *args: function(*args)

    original = compiled(SOURCE)
    copy = Rebuilder(convert, 'elsewhere').copy(original)
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
    assert (copy.__name__, copy.__module__) == ('f', 'elsewhere')


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


def test_a_function_may_be_called_like_an_attribute_that_it_uses() -> None:
    def sqrt(x: float) -> float:
        return float(np.sqrt(x))

    scope = {**sqrt.__globals__, 'sqrt': sqrt}
    named = FunctionType(sqrt.__code__, scope, 'sqrt')
    scope['sqrt'] = named
    assert rebuilt(named, lambda function: function)(4.0) == 2.0


def test_a_function_may_be_called_like_an_attribute_of_another_module_that_holds_it() -> None:
    tools, plant = ModuleType('tools'), ModuleType('plant')
    exec('def low(x): return x - 1.0', tools.__dict__)
    exec(
        'import numpy as np\ndef sign(x): return tools.low(np.sign(x))',
        plant.__dict__,
    )
    plant.__dict__['tools'] = tools
    tools.__dict__['sign'] = plant.__dict__['sign']
    assert rebuilt(plant.__dict__['sign'], lambda function: function)(3.0) == 0.0


def test_selects_replace_numpys_functions_by_whatever_way_they_are_reached() -> None:
    inner, package = ModuleType('inner'), ModuleType('package')
    exec('import numpy as np\ndef low(x): return np.minimum(x, 1.0)', inner.__dict__)
    package.__dict__.update(inner=inner, package=package)  # modules may name each other
    least = np.minimum

    def f(x: float) -> float:
        return float(np.clip(x, 0, 3) + where(x > 2, 1, 0) + least(x, 2) + package.inner.low(x))

    seen: list[str] = []

    def convert(function: FunctionType) -> FunctionType:
        seen.append(function.__name__)
        return function

    copy = rebuilt(f, convert)
    assert copy(2.5) == f(2.5) == 6.5
    assert sorted(seen) == ['clip', 'low', 'lowered', 'maximum', 'minimum', 'raised', 'where']
    assert package.__dict__['inner'] is inner
    assert np.clip.__module__.partition('.')[0] == 'numpy'


def test_functions_that_make_arrays_are_named() -> None:
    def helper(x: float) -> float:
        return float(np.interp(x, TABLE, TABLE) + np.sqrt(np.abs(np.clip(x, 0, 1))) + np.pi)

    def f(x: float) -> float:
        return float(helper(x) + zeros(3)[0] + np.float64(1.0) + np.where(x > 0, 1, 0))

    rebuilder = Rebuilder(lambda function: function, 'elsewhere')
    scope = {**f.__globals__, 'helper': helper}
    rebuilder.copy(FunctionType(helper.__code__, scope))
    rebuilder.copy(FunctionType(f.__code__, scope, 'f', None, f.__closure__))
    assert rebuilder.slow == {'interp', 'zeros'}
