"""Tests of obs_ros.integration.inlining: what is written out does the same as what is called."""

import ast

import numpy as np
import pytest

from obs_ros.integration.inlining import inlined, parsed
from obs_ros.integration.kernel_source import filter_source, source
from obs_ros.models import MODELS, load_model

TEXT = """
@jit
def pair(a, b):
    return (a, b)

@jit
def scaled(x, factor):
    x = (x[0] * factor, x[1] * factor)
    total = x[0] + x[1]
    return x, total

@jit
def step_plain(x, h):
    both, total = scaled(x, h + 1.0)
    return pair(both[0], total)

@jit
def put(out, i, x):
    '''Write a pair.'''
    out[i, 0] = x[0]
    out[i, 1] = x[1]

@jit
def sign(x):
    if x > 0.0:
        return 1.0
    return -1.0

@jit
def march(out, h):
    for i in range(1, len(out)):
        put(out, i, step(pair(out[i - 1, 0], out[i - 1, 1]), h))

step = step_plain

@entry
def kernel(out, h):
    '''Fill in rows.'''
    total = 3.0
    put(out, 0, pair(1.0, total))
    if out[0, 0] > 0.0:
        march(out, h)
    k = 0
    while k < 2 and sign(out[k, 1]) > 0.0:
        put(out, k, pair(out[k, 0], sign(total - 5.0) if k else 7.0))
        k += 1
"""


def run(text: str) -> np.ndarray:
    scope: dict[str, object] = dict.fromkeys(('jit', 'entry'), lambda function: function)
    exec(text, scope)
    out = np.zeros((4, 2))
    scope['kernel'](out, 0.5)  # type: ignore[operator]
    return out


def called(text: str, function: str) -> set[str]:
    """Return the names of the functions that one calls."""
    (own,) = (f for f in ast.parse(text).body if getattr(f, 'name', '') == function)
    calls = (each for each in ast.walk(own) if isinstance(each, ast.Call))
    return {each.func.id for each in calls if isinstance(each.func, ast.Name)}


def test_written_out_it_computes_the_same_bits() -> None:
    np.testing.assert_array_equal(run(inlined(TEXT)), run(TEXT))
    assert run(TEXT)[3, 1] > 0.0


def test_short_helpers_are_written_out_and_those_with_loops_or_early_returns_called() -> None:
    text = inlined(TEXT)
    assert called(text, 'kernel') == {'sign', 'march'}
    assert called(text, 'march') == {'range', 'len'}


@pytest.mark.parametrize('name', MODELS)
def test_kernels_of_every_model_call_no_short_helper(name: str) -> None:
    model = load_model(name)
    for text in (inlined(source(model)), inlined(filter_source(model, len(model.states)))):
        assert called(text, 'squares') <= {'range', 'max', 'load', 'advance', 'output'} | {
            'shortest', 'min',
        }  # fmt: skip


def test_what_is_written_out_everywhere_is_left_out() -> None:
    left = {
        each.name for each in ast.parse(inlined(TEXT)).body if isinstance(each, ast.FunctionDef)
    }
    assert left == {'sign', 'march', 'kernel'}


def test_a_text_is_parsed_again_where_another_thread_stood_in_the_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plain, tries = ast.parse, []

    def refusing(text: str) -> ast.Module:
        tries.append(text)
        if len(tries) < 3:
            raise SystemError('AST constructor recursion depth mismatch (before=84, after=164)')
        return plain(text)

    monkeypatch.setattr(ast, 'parse', refusing)
    assert isinstance(parsed('x = 1'), ast.Module) and len(tries) == 3
