"""Tests of obs_ros.inference.assessment.outcome."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plants import OSCILLATOR

from obs_ros import Outcome
from obs_ros.inference.assessment.outcome import (
    Findings,
    judged,
    states_at_bound,
    unknowns_at_bound,
)
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Effort, Found

FOUND = Found(
    np.full(4, 0.5), 1.0, converged=True, accepted=Acceptance.METHOD, effort=Effort(2, 'round')
)
FIT = SimpleNamespace(
    too_large=False, too_small=False, negligible=False, ratio=1.0,
    white=True, colour=SimpleNamespace(correlation=0.0),
)  # fmt: skip
GOOD = Findings(
    found=FOUND, fit=FIT, uncertainty=None, candidates=7, in_time=True, squares=True,
    undetermined=(), unidentified='', bounds='', resting='',
)  # type: ignore[arg-type]  # fmt: skip


def fit(**changes: Any) -> Any:
    return SimpleNamespace(**{**vars(FIT), **changes})


def searched(**changes: Any) -> Any:
    plain = {
        'finished': True,
        'drifting': False,
        'jumps': (),
        'disturbance': '',
        'skill': None,
        'flaws': '',
    }
    return SimpleNamespace(**{**plain, **changes})


# In the order of the table: each is followed by those that it goes before.
CASES = [
    (
        {'uncertainty': searched(finished=False)}, Outcome.DEADLINE,
        'allow more time, or shorten the window: none was left to look for jumps '
        'or process noise',
    ),
    (
        {'uncertainty': searched(drifting=True, jumps=(1, 2, 3))}, Outcome.MODEL_MISMATCH,
        'shorten the window: 3 jumps in it, or a drifting parameter; '
        'standard deviations are withheld',
    ),
    (
        {'found': replace(FOUND, accepted=None)}, Outcome.DEADLINE,
        'allow more rounds, or shorten the window: best of 7 candidates in 2 rounds, not confirmed',
    ),
    (
        {'fit': fit(too_large=True, ratio=2.5)}, Outcome.MODEL_MISMATCH,
        'check the noise, the model and its fixed values, or shorten the window: '
        'the residual is 2.5 times the noise, given or learned',
    ),
    (
        {'fit': fit(too_small=True, ratio=0.5)}, Outcome.MODEL_MISMATCH,
        'check the noise if it is given: the residual is only 0.5 times the noise, '
        'given or learned; standard deviations are too large',
    ),
    (
        {'fit': fit(white=False, colour=SimpleNamespace(correlation=0.8))}, Outcome.MODEL_MISMATCH,
        'look for what the model leaves out, a parameter that moved inside the window, or coarse '
        'rounding: the residual is not white, its lag-1 correlation is 0.8',
    ),
    ({'undetermined': ('k',), 'unidentified': 'move; k'}, Outcome.NOT_IDENTIFIABLE, 'move; k'),
    (
        {'bounds': 'k is at its lower bound 0'}, Outcome.AT_BOUND,
        f'check the bounds, or the model: k is at its lower bound 0; {Acceptance.METHOD}',
    ),
    ({}, Outcome.CONVERGED, Acceptance.METHOD.value),
]  # fmt: skip


@pytest.mark.parametrize('first', range(len(CASES)))
def test_the_first_rule_that_applies_decides(first: int) -> None:
    for later in range(first, len(CASES)):
        if (first, later) == (1, 2):
            continue  # only a search that is believed tells a drift
        changes = {**CASES[later][0], **CASES[first][0]}
        outcome, message = judged(replace(GOOD, **changes))
        assert (outcome, message) == CASES[first][1:], CASES[later][1]


def test_without_time_the_advice_is_more_time() -> None:
    findings = replace(GOOD, found=replace(FOUND, accepted=None), in_time=False)
    assert judged(findings)[1].startswith('allow more time, or')


@pytest.mark.parametrize('first', range(len(CASES)))
def test_states_that_rest_at_a_bound_are_said_first(first: int) -> None:
    changes, outcome, message = CASES[first]
    found = judged(replace(GOOD, resting='x lies at its lower bound 0', **changes))
    expected = Outcome.AT_BOUND if outcome is Outcome.CONVERGED else outcome
    assert found[0] is expected
    assert found[1] == f'x lies at its lower bound 0: check the bounds, or the model; {message}'


def test_a_colour_that_is_rounding_or_no_square_is_no_mismatch() -> None:
    coloured = fit(white=False, colour=SimpleNamespace(correlation=0.8))
    for changes in ({'fit': SimpleNamespace(**{**vars(coloured), 'negligible': True})},
                    {'fit': coloured, 'squares': False}):  # fmt: skip
        assert judged(replace(GOOD, **changes))[0] is Outcome.CONVERGED


def test_a_state_may_touch_its_bound_for_a_moment() -> None:
    states = np.zeros((100, 2))
    states[:2, 0], states[:, 1] = -3.0, 1.0
    assert states_at_bound(OSCILLATOR, states) == ''
    states[:3, 0] = -3.0
    assert states_at_bound(OSCILLATOR, states) == 'position lies at its lower bound -3'
    states[:3, 1] = 3.1
    assert states_at_bound(OSCILLATOR, states).endswith(', velocity lies at its upper bound 3 m/s')


def test_unknowns_at_their_bounds_are_named_with_units() -> None:
    unknowns = Unknowns.of(OSCILLATOR)
    assert unknowns_at_bound(unknowns, np.full(4, 0.5)) == ''
    assert unknowns_at_bound(unknowns, np.array([0.5, 1.0, 0.0, 0.5])) == (
        'velocity is at its upper bound 3 m/s, stiffness is at its lower bound '
        f'{OSCILLATOR.parameters[0].lower:g}'
    )
    free = Unknowns.of(OSCILLATOR, bounds={'stiffness': (-np.inf, 2.0)})
    assert unknowns_at_bound(free, np.array([0.5, 0.5, 0.0, 0.5])) == ''


UNSKILLED = (
    'check units, inputs, fixed values and bounds: forecasts of the model are no better than '
    'holding the last value'
)
ROUGH = 'look for what the model leaves out: it is only roughly right'
GRADES = [
    (-0.5, {}, Outcome.MODEL_MISMATCH, f'{UNSKILLED}; standard deviations are withheld'),
    (
        -0.5, {'fit': fit(too_large=True, ratio=2.5)}, Outcome.MODEL_MISMATCH,
        f'{UNSKILLED}; the residual is 2.5 times the noise, given or learned; '
        'standard deviations are withheld',
    ),
    (
        0.9, {'fit': fit(too_small=True, ratio=0.5)}, Outcome.APPROXIMATE,
        f'{ROUGH}; the residual is only 0.5 times the noise, given or learned',
    ),
    (
        0.9, {'fit': fit(too_large=True, ratio=11.0)}, Outcome.MODEL_MISMATCH,
        'check the noise, the model and its fixed values, or shorten the window: '
        'the residual is 11 times the noise, given or learned',
    ),
    (
        0.4, {'bounds': 'k is at its lower bound 0'}, Outcome.APPROXIMATE,
        f'{ROUGH}; process noise is large; k is at its lower bound 0',
    ),
    (
        0.4, {'undetermined': ('k',), 'unidentified': 'move; k'}, Outcome.APPROXIMATE,
        f'{ROUGH}; process noise is large; move; k',
    ),
    (0.6, {}, Outcome.CONVERGED, Acceptance.METHOD.value),
]  # fmt: skip


@pytest.mark.parametrize(('skill', 'changes', 'outcome', 'message'), GRADES)
def test_forecasts_grade_a_window_that_noise_alone_does_not_explain(
    skill: float, changes: dict[str, Any], outcome: Outcome, message: str
) -> None:
    found = judged(replace(GOOD, uncertainty=searched(skill=skill), **changes))
    ahead = f'forecasts an eighth of a window ahead have skill {skill:.2f}'
    assert found == (outcome, f'{message}; {ahead}')


def test_flaws_of_the_structure_make_a_model_that_foretells_well_a_rough_one() -> None:
    flawed = searched(skill=0.9, flaws='k not constant in the window')
    outcome, message = judged(replace(GOOD, uncertainty=flawed))
    assert outcome is Outcome.APPROXIMATE
    assert message.startswith(f'{ROUGH}; k not constant in the window; forecasts')


def test_process_noise_is_named_behind_the_reason() -> None:
    pushed = searched(disturbance='pushed about')
    assert judged(replace(GOOD, uncertainty=pushed)) == (
        Outcome.CONVERGED, f'{Acceptance.METHOD}; pushed about',
    )  # fmt: skip


@pytest.mark.parametrize('first', range(len(CASES)))
def test_priors_that_are_contradicted_are_said_before_all(first: int) -> None:
    changes, outcome, message = CASES[first]
    said = 'k = 2.1 contradicts its prior 3 (sd 0.2) by 4.5 standard deviations'
    found = judged(replace(GOOD, contradicted=said, **changes))
    assert found == (outcome, f'check the prior, or the model: {said}; {message}')
