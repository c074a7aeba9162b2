"""Tests of obs_ros.core.prior_knowledge."""

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from plants import LAG

from obs_ros.core.prior_knowledge import with_knowledge, without_knowledge


def test_what_is_given_takes_the_place_of_the_models() -> None:
    found = with_knowledge(LAG, {'k': 0.1, 'x': 0.2}, {'k': (2.0, 0.5), 'tau': (5.0, 1.0)})
    assert [v.walk for v in found.variables] == [0.2, 0.1, None]
    assert [v.prior for v in found.variables] == [None, (2.0, 0.5), (5.0, 1.0)]
    other = with_knowledge(found, {'k': 0.3, 'x': 0.0}, {'tau': None})
    assert [v.walk for v in other.variables] == [None, 0.3, None]
    assert [v.prior for v in other.variables] == [None, (2.0, 0.5), None]
    assert replace(other, states=LAG.states, parameters=LAG.parameters) == LAG


def test_without_anything_given_it_is_the_same_model() -> None:
    assert with_knowledge(LAG) is LAG and with_knowledge(LAG, {}, {}) is LAG
    plain = replace(LAG, max_step=math.inf)
    assert without_knowledge(plain) is plain
    known = with_knowledge(LAG, {'k': 0.1}, {'x': (0.0, 1.0)})
    assert without_knowledge(known) == without_knowledge(LAG) == plain


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({'walks': {'kk': 0.1}}, "model 'lag' has no state or parameter 'kk': did you mean 'k'?"),
        ({'priors': {'taw': (1, 1)}}, "no state or parameter 'taw': did you mean 'tau'?"),
        ({'walks': {'u': 0.1}}, "model 'lag' has no state or parameter 'u': "),
        ({'walks': {'k': -0.1}}, 'k: walk -0.1 is not positive'),
        ({'walks': {'k': 'far'}}, "k: walk must be a number, not 'far'"),
        ({'walks': {'x': float('inf')}}, 'give state x a finite walk, not inf'),
        ({'priors': {'k': (3.0, 0.0)}}, 'k: prior standard deviation 0.0 is not positive'),
        ({'walks': 0.1}, 'walks must be given by name, not as 0.1'),
        ({'priors': [('k', (1, 1))]}, "priors must be given by name, not as [('k', (1, 1))]"),
    ],
)
def test_what_is_wrong_is_named(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        with_knowledge(LAG, **given)
