"""Tests of obs_ros.core.model_check: what users get wrong in a plant, and what they are told."""

import importlib.util
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from obs_ros import Model, Variable

HEAD = """\
import math
import numpy as np

def dynamics(t, x, u, p):
    angle, rate = x
"""


def plant(folder: Path, body: str, output: str = 'return (x[0],)', **changes: Any) -> Model:
    """A pendulum whose dynamics are a file's: `body` begins at line 6."""
    indented = ''.join(f'    {line}\n' for line in body.splitlines())
    path = folder / 'my_plant.py'
    path.write_text(f'{HEAD}{indented}\n\ndef output(t, x, u, p):\n    {output}\n')
    spec = importlib.util.spec_from_file_location('my_plant', path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    settings: dict[str, Any] = {
        'name': 'pendulum',
        'states': [Variable('angle', lower=-3.0, upper=3.0), Variable('rate')],
        'inputs': [Variable('torque')],
        'outputs': [Variable('angle')],
        'parameters': [Variable('stiffness', nominal=0.0, lower=0.0, upper=9.0)],
        'dynamics': module.dynamics,
        'output': module.output,
    }
    return Model(**(settings | changes))


@pytest.mark.parametrize(
    ('body', 'words', 'line'),
    [
        (
            'return rate, u[0], p[0]',
            'a tuple of 2 entries, one number for each candidate and each of angle, rate, not 3',
            6,
        ),
        ('return rate', 'not an array of shape (16,)', 6),
        ('return {0: u[0]}', 'not the dict', 6),
        ('rate + u[0]', 'not None: is the `return` missing?', 6),
        ('k = p[0]\nk * angle', 'not None: is the `return` missing?', 7),
        ('return rate, "fast"', "that of rate is the str 'fast'", 6),
        ('return rate, np.array(x)', 'that of rate is an array of shape (2, 16)', 6),
        (
            'return rate, u[0] / p[0]',
            'is not finite: rate is inf at angle = 0, rate = 1, torque = 1, stiffness = 0, nor is '
            "it anywhere else that was tried, FloatingPointError('divide by zero encountered in",
            6,
        ),
        ('k = np.sqrt(p[0] - 1)\nreturn rate, k', 'rate is nan', 6),
        ('return np.inf, rate', 'is not finite: angle is inf', 6),
        ('return rate, 1 / 0', "arrays over candidates: ZeroDivisionError('division by zero')", 6),
        ('if angle > 0:\n    rate = -rate\nreturn rate, 0 * p[1]', "IndexError('tuple index", 8),
        ('return rate, max(angle, None)', 'arrays over candidates: TypeError', 6),
        ('k, d = p\nreturn rate, k', "not enough values to unpack (expected 2, got 1)') (x has 2: "
         'angle, rate; u has 1: torque; p has 1: stiffness)', 6),
        ('a, = x\nreturn rate, a', "too many values to unpack (expected 1)') (x has 2: angle", 6),
        ('k = 1.0\nreturn rate, p[1]', "tuple index out of range') (x has 2", 7),
        ('return rate, math.sin(x)', 'candidate by candidate: TypeError', 6),
        ('return rate, stifness', "name 'stifness' is not defined", 6),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_words_with_its_line(
    tmp_path: Path, body: str, words: str, line: int
) -> None:
    with pytest.raises(ValueError) as caught:
        plant(tmp_path, body)
    message = str(caught.value)
    assert message.startswith("model 'pendulum': dynamics ") and words in message
    text = body.splitlines()[line - 6].strip()
    assert message.endswith(f'(my_plant.py:{line}: `{text}`)')


@pytest.mark.parametrize(
    ('output', 'words'),
    [('return x[0]', 'write a comma, `return (value,)`'), ('return x', 'not 2 (my_plant.py:')],
)
def test_outputs_are_tried_as_well(tmp_path: Path, output: str, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        plant(tmp_path, 'return rate, angle', output)


def test_a_helper_is_blamed_at_the_line_that_calls_it(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=re.escape('(my_plant.py:6: `return rate, np.dot(x, u)`)')):
        plant(tmp_path, 'return rate, np.dot(x, u)')


def test_too_few_arguments_are_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=re.escape('(it is called with t, x, u, p)')):
        plant(tmp_path, 'return rate, angle', dynamics=lambda t, x, u: (0.0, 0.0))


def test_a_model_that_is_infinite_at_some_points_only_is_one(tmp_path: Path) -> None:
    assert plant(tmp_path, 'return rate, 1.0 / angle').name == 'pendulum'
    assert plant(tmp_path, 'return rate, np.log(angle - 2.0)').name == 'pendulum'


def test_constants_and_mixed_entries_are_numbers_too(tmp_path: Path) -> None:
    model = plant(tmp_path, 'return 1, np.where(angle > 0, rate, -rate)')
    assert np.shape(model.dynamics(0.0, (1.0, 2.0), (0.0,), (1.0,))) == (2,)
