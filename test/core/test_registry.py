"""Tests of obs_ros.core.registry."""

import math
import re
from typing import Any

import pytest

from obs_ros.core.registry import lookup, suggest

TABLE = {'pi': 'math:pi', 'tau': 'math:tau'}


def test_a_name_of_the_table_and_a_path_lead_to_the_object() -> None:
    assert lookup('number', 'pi', TABLE) is math.pi
    assert lookup('number', 'math:e', TABLE) is math.e


def test_a_path_to_the_users_own_module(tmp_path, monkeypatch) -> None:
    (tmp_path / 'registry_own.py').write_text('ANSWER = 42\n')
    monkeypatch.syspath_prepend(tmp_path)
    assert lookup('number', 'registry_own:ANSWER', TABLE) == 42


@pytest.mark.parametrize(
    ('name', 'message'),
    [
        ('pie', "unknown number 'pie': did you mean 'pi'?"),
        ('xyzzy', "unknown number 'xyzzy': known are pi, tau"),
        ('', "unknown number ''"),
        ('math:', "number 'math:' is not of the form package.module:ATTRIBUTE"),
        (':pi', "number ':pi' is not of the form package.module:ATTRIBUTE"),
        ('.math:pi', "number '.math:pi' is not of the form package.module:ATTRIBUTE"),
        (None, 'number must be a name, not None'),
        (42, 'number must be a name, not 42'),
        ('math:taau', "module math has no 'taau': did you mean 'tau'"),
        (
            'no_such_package.plant:A',
            '("No module named \'no_such_package\'"); is its package installed?',
        ),
    ],
)
def test_what_is_wrong_is_named(name: Any, message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        lookup('number', name, TABLE)


def test_a_module_that_lacks_one_of_its_own_imports_says_which(tmp_path, monkeypatch) -> None:
    (tmp_path / 'registry_broken.py').write_text('import no_such_dependency\n')
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ValueError, match="'no_such_dependency'"):
        lookup('number', 'registry_broken:A', TABLE)


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('x = 1\ndef f(:\n', "SyntaxError('invalid syntax (registry_wrong.py, line 2)')"),
        ('x = 1\ny = z\n', """NameError("name 'z' is not defined") (registry_wrong.py:2)"""),
        (
            'from obs_ros import Variable\n\nA = Variable("a b")\n',
            "number 'registry_wrong:A': variable name 'a b' is not an identifier "
            '(registry_wrong.py:3)',
        ),
    ],
)
def test_a_module_that_fails_says_where(tmp_path, monkeypatch, text: str, message: str) -> None:
    (tmp_path / 'registry_wrong.py').write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ValueError, match=re.escape(message)):
        lookup('number', 'registry_wrong:A', TABLE)


def test_suggestions_prefer_close_matches_and_else_list_all() -> None:
    known = ('memetic', 'chaotic_de')
    assert suggest('mimetic', known) == "did you mean 'memetic'?"
    assert suggest('zzz', known) == 'known are chaotic_de, memetic'
    assert suggest('zzz', ()) == 'known are none'
