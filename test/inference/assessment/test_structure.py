"""Tests of obs_ros.inference.assessment.structure."""

from typing import Any

import numpy as np
import pytest
from plants import LAG, square_wave

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.structure import Structure

K, TAU, SIGMA, INTERVAL, NODES = 1.2, 3.0, 0.02, 0.1, 300
T = INTERVAL * np.arange(NODES)


def pushed(seed: int, gain: Any = K, sign: float = 1.0) -> Record:
    """A lag whose state is pushed about, its gain a number or of each sample."""
    rng = np.random.default_rng([seed, 13])
    u = square_wave(T) * np.repeat(rng.uniform(0.5, 1.5, NODES // 30), 30)
    hold, x, gains = np.exp(-INTERVAL / TAU), np.empty(NODES), np.broadcast_to(gain, NODES)
    x[0] = 0.5
    for k in range(NODES - 1):
        end = gains[k] * u[k]
        x[k + 1] = end + (x[k] - end) * hold + 0.02 * rng.standard_normal()
    return Record(T, sign * u, x + SIGMA * rng.standard_normal(NODES))


def share(said: str, **changes: Any) -> float:
    found = [solve_window(LAG, pushed(seed, **changes), seed=1) for seed in range(30)]
    return float(np.mean([said in one.message for one in found]))


def test_nothing_speaks_against_a_right_model_that_is_pushed_about() -> None:
    found = [solve_window(LAG, pushed(seed), seed=1) for seed in range(30)]
    assert sum(one.outcome is Outcome.CONVERGED for one in found) >= 29
    assert not any('not constant' in one.message for one in found[:20])


def test_a_parameter_that_moves_is_named_and_has_no_deviation() -> None:
    ramp: Array = np.linspace(0.8, 1.6, NODES)
    found = [solve_window(LAG, pushed(seed, ramp), seed=1) for seed in range(20)]
    named = [one for one in found if 'k' in one.message and 'not constant' in one.message]
    assert len(named) >= 15
    for one in named:
        assert one.outcome is Outcome.APPROXIMATE
        assert np.isnan(one.stddev['k'])


def test_an_input_of_the_wrong_sign_is_no_disturbance() -> None:
    found = [solve_window(LAG, pushed(seed, sign=-1.0), seed=1) for seed in range(20)]
    assert not any(one.outcome in (Outcome.CONVERGED, Outcome.AT_BOUND) for one in found)


@pytest.mark.parametrize(('moving', 'inputs', 'words'), [
    ([False, False], (), ''),
    ([True, False], (), 'k not constant in the window'),
    ([False, False], ('u',), 'the residual depends on earlier u'),
    (
        [True, True], ('u',),
        'k and tau not constant in the window, the residual depends on earlier u',
    ),
])  # fmt: skip
def test_words(moving: list[bool], inputs: tuple[str, ...], words: str) -> None:
    assert Structure(np.array(moving), inputs).words(('k', 'tau')) == words
