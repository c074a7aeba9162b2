"""Tests of obs_ros.samples.break_detector."""

import numpy as np

from obs_ros.samples.break_detector import Suspects, describe_break

VALUES = np.zeros(1)
BELIEVED = 5


def test_five_rising_samples_are_believed() -> None:
    suspects = Suspects(BELIEVED)
    for stamp in range(BELIEVED):
        assert not suspects.believed
        suspects.add(stamp, VALUES, ahead=False)
    assert suspects.believed
    assert [stamp for stamp, _ in suspects.release()] == [0, 1, 2, 3, 4]
    assert len(suspects) == 0


def test_stamps_that_do_not_rise_start_anew() -> None:
    suspects = Suspects(BELIEVED)
    for _ in range(20):
        suspects.add(0, VALUES, ahead=False)
        assert len(suspects) == 1


def test_strays_far_ahead_are_counted_when_they_prove_strays() -> None:
    suspects = Suspects(BELIEVED)
    assert suspects.add(1, VALUES, ahead=False) == 0
    assert suspects.add(100, VALUES, ahead=True) == 0
    assert suspects.add(200, VALUES, ahead=True) == 0
    assert suspects.add(150, VALUES, ahead=True) == 2
    assert suspects.clear() == 1
    assert suspects.clear() == 0


def test_a_late_sample_before_a_gap_does_not_belong_to_those_after_it() -> None:
    suspects = Suspects(BELIEVED)
    suspects.add(5, VALUES, ahead=False)
    for stamp in range(100, 104):
        suspects.add(stamp, VALUES, ahead=True)
    assert not suspects.believed
    suspects.add(104, VALUES, ahead=True)
    assert suspects.release()[0][0] == 100


def test_released_samples_are_no_strays() -> None:
    suspects = Suspects(BELIEVED)
    suspects.add(100, VALUES, ahead=True)
    suspects.release()
    assert suspects.clear() == 0


def test_message_tells_where_from_and_where_to() -> None:
    assert describe_break('output', 2_500_000_000_000, 0) == (
        'output stamps jumped back from 2500.0 s to 0.0 s: all samples forgotten'
    )
    assert 'jumped ahead from 1.5 s to 90.0 s' in describe_break('input', 15 * 10**8, 90 * 10**9)
