"""Tests of obs_ros.inference.jumps.settings."""

import math
from dataclasses import replace

import pytest
from jump_windows import record, still

from obs_ros.core.deadline import Deadline
from obs_ros.inference.jumps.jump_search import JumpSearch
from obs_ros.inference.jumps.settings import JumpSettings


def test_penalties_are_minus_two_log_probabilities() -> None:
    settings = JumpSettings(prior_probability=0.2, further_probability=0.5)
    assert math.exp(-0.5 * settings.jump_penalty) == pytest.approx(0.2)
    assert math.exp(-0.5 * settings.further_penalty) == pytest.approx(0.5)
    # As likely as the time is long in which nobody looked, and never more than certain.
    assert math.exp(-0.5 * settings.earlier_penalty(0.5)) == pytest.approx(0.1)
    assert settings.earlier_penalty(100.0) == 0.0
    # The gap, and the share of the window before it in which no jump could be seen.
    assert settings.unseen(0.5, visible=0.0) == 1.5
    assert settings.unseen(0.5, visible=4.0 * settings.jump_penalty) == 0.75


@pytest.mark.parametrize(
    ('changed', 'jumps'), [({}, 1), ({'most_jumps': 0}, 0), ({'prior_probability': 1e-99}, 0)]
)
def test_a_search_takes_the_settings_of_its_problem(changed: dict[str, float], jumps: int) -> None:
    base = still(record(0.3))
    problem = replace(base.problem, settings=JumpSettings(**changed))
    found = JumpSearch(replace(base, problem=problem), Deadline(), known=None).run()
    assert found.jumps == jumps
