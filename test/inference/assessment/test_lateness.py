"""Tests of obs_ros.inference.assessment.lateness."""

import numpy as np
import pytest
from offset_spring import measured, plain_window, spring

from obs_ros import Estimate, Outcome, Record, Sample, solve_window
from obs_ros.inference.assessment.lateness import Late, remarked
from obs_ros.observers.sliding_window import SlidingWindowObserver


def window(seed: int, speed: float = 0.0, force: float = 0.0, **more: float) -> Record:
    return plain_window(measured(np.random.default_rng(seed), speed, force, **more)[0])


def remark(record: Record) -> str:
    return solve_window(spring(), record, seed=1).message.rpartition('; ')[2]


@pytest.mark.parametrize(('late', 'words'), [(0.048, 'late'), (0.005, 'late'), (-0.03, 'early')])
def test_a_late_output_is_named_with_its_delay(late: float, words: str) -> None:
    for seed in range(2):
        said = remark(window(seed, speed=late)).split()
        assert said[:2] == ['speed', 'looks'] and said[3:] == ['ms', words]
        assert float(said[2]) == pytest.approx(1e3 * abs(late), rel=0.15)


def test_a_force_that_acts_late_is_told_from_outputs_that_are_late() -> None:
    said = remark(window(1, force=0.02)).split()
    assert said[:2] == ['force', 'looks'] and float(said[2]) == pytest.approx(20.0, rel=0.1)


def test_neither_noise_nor_friction_that_the_model_lacks_looks_late() -> None:
    for seed in range(3):
        for friction in (0.0, 0.5, 1.0):
            assert 'looks' not in remark(window(seed, friction=friction))


def test_a_moving_horizon_says_so_when_three_windows_agree() -> None:
    observer = SlidingWindowObserver(spring(), duration=0.9, seed=1)
    record, said = window(2, speed=0.03), []
    for t, u, y in zip(record.t, record.u, record.y, strict=True):
        if observer.absorb(Sample(round(t * 1e9), u=u, y=y)):
            estimate = observer.estimate()
            assert estimate is not None
            said.append('speed looks' in estimate.message)
    assert said == [False, False, True]


def test_what_looks_late_is_said_in_ms() -> None:
    assert str(Late('speed', 0.04781)) == 'speed looks 48 ms late'
    assert str(Late('speed', -1.2)) == 'speed looks 1200 ms early'
    assert str(Late('a and b', 0.0012)) == 'a and b look 1.2 ms late'
    assert Late('speed', 0.04).agrees(Late('speed', 0.05))
    assert not Late('speed', 0.04).agrees(Late('speed', 0.07))
    assert not Late('speed', 0.04).agrees(Late('speed', -0.04))
    assert not Late('speed', 0.04).agrees(Late('angle', 0.04))


def test_a_remark_stands_at_the_end() -> None:
    estimate = Estimate({}, {}, {}, {}, Outcome.CONVERGED, 'fine', 0.0, 1.0)
    assert remarked(estimate, 'speed looks 48 ms late').message == 'fine; speed looks 48 ms late'
    assert remarked(estimate, '') is estimate
