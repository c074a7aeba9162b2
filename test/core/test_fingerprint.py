"""Tests of obs_ros.core.fingerprint."""

import os
import subprocess
import sys
from collections import namedtuple
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest

from obs_ros.core.fingerprint import fingerprint

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
    def f(t, x, u, p, bias=0.5, *, offset=0.25):
        return offset + GAIN * helper(x) + k + TABLE[0] + PAIR[1] + np.sqrt(x) + bias
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
        ('offset=0.25', 'offset=0.75'),
        ('np.sqrt', 'np.exp'),
        ('GAIN * helper', 'GAIN + helper'),
        ('import numpy as np', "import numpy as np\n__name__ = 'renamed'"),
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


def test_constants_of_a_module_inside_a_package_count() -> None:
    package, inner, unused = ModuleType('package'), ModuleType('inner'), ModuleType('unused')
    package.__dict__.update(inner=inner, unused=unused)
    inner.__dict__.update(GAIN=1.0, package=package)  # modules may name each other
    unused.__dict__.update(GAIN=1.0)

    def f(x: float) -> float:
        return float(package.inner.GAIN * x)

    prints = [fingerprint('', f)]
    inner.__dict__['GAIN'] = 2.0
    prints.append(fingerprint('', f))
    unused.__dict__['GAIN'] = 2.0
    assert prints[0] != prints[1] == fingerprint('', f)


def test_constants_in_lists_and_the_fields_of_named_tuples_count() -> None:
    prints = set()
    for numbers, fields in (([1.0], 'a b'), ([2.0], 'a b'), ([1.0], 'b a')):
        pair, table = namedtuple('pair', fields), [np.full(2000, *numbers)]

        def f(x: float, pair: Any = pair, table: Any = table) -> float:
            return float(table[0][0] * pair(x, 1.0).a)

        prints.add(fingerprint('', f))
    assert len(prints) == 3


def test_the_order_of_the_fields_of_a_workspace_counts_also_of_one_inside_it() -> None:
    """Compiled code knows them by their places."""
    prints = set()
    for outer, inner in (('aw', 'bc'), ('aw', 'cb'), ('wa', 'bc')):
        parts = NamedTuple('parts', [(name, float) for name in inner])
        kinds = {'a': float, 'w': parts}
        workspace = NamedTuple('workspace', [(name, kinds[name]) for name in outer])

        def f(w: Any) -> Any:
            return w.a + w.w.b

        f.__annotations__['w'] = workspace
        prints.add(fingerprint('', f))
    assert len(prints) == 3


IMPORTED = """
from numpy import where
from obs_ros.core.fingerprint import fingerprint

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
