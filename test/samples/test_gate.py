"""Tests of how samples are ordered, counted and handed out one by one."""

import numpy as np
import pytest

from obs_ros import Sample
from obs_ros.integration.input_history import MOST
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.gate import COUNTS, Intake

S = 10**9
FEED, LEVELS = np.array([30.0, 30.0]), np.array([1.0, 2.0])


def intake(longest_gap: float = 0.0) -> Intake:
    found = Intake(THREE_TANK, longest_gap)
    found.push(Sample(0, u=FEED))
    return found


def push(found: Intake, *seconds: float) -> list[float]:
    """Push outputs; return the times of those handed out."""
    return [stamp / S for t in seconds for stamp, _ in found.push(Sample(round(t * S), y=LEVELS))]


def test_outputs_come_out_once_and_in_order() -> None:
    found = intake()
    assert push(found, 1, 2, 2, 1, 3, 2.5, 4) == [1, 2, 3, 4]
    assert (found.counts['duplicate'], found.counts['late']) == (1, 2)


def test_the_samples_arrays_are_copied_into_one_layout() -> None:
    found = intake()
    wide = np.array([[1.0, 9.0, 2.0, 9.0]])[0, ::2]
    wide.flags.writeable = False
    ((_, y),) = found.push(Sample(S, y=wide))
    assert y.flags.c_contiguous and y.flags.writeable and y.tolist() == [1.0, 2.0]


def test_nan_counts_and_infinity_is_not_measured() -> None:
    found = intake()
    ((_, y),) = found.push(Sample(S, y=np.array([np.inf, 2.0])))
    assert np.isnan(y[0]) and y[1] == 2.0
    assert found.push(Sample(2 * S, y=np.array([np.nan, -np.inf]))) == []
    assert (found.counts['nan'], found.counts['all_nan']) == (1, 1)


@pytest.mark.parametrize('beyond', [2**62, -(2**62)])
def test_impossible_stamps_are_counted(beyond: int) -> None:
    found = intake()
    assert found.push(Sample(beyond, y=LEVELS)) == []
    assert found.counts['out_of_range'] == 1


def test_a_stray_far_ahead_is_dropped_and_told_by_the_next_sample() -> None:
    found = intake()
    assert push(found, 1, 2, 90_000, 3, 4) == [1, 2, 3, 4]
    assert found.counts['ahead'] == 1 and found.last_break is None


def test_five_samples_back_in_time_start_it_anew_and_none_of_them_is_lost() -> None:
    found = intake()
    found.push(Sample(1000 * S, u=FEED))
    push(found, 1000, 1001)
    found.push(Sample(0, u=FEED))  # not newer than the input known: a suspect as well
    for t in (1, 2, 3, 4):
        assert push(found, t) == []
    assert push(found, 5) == [1, 2, 3, 4, 5]
    assert found.last_break
    assert found.last_break.startswith('output stamps jumped back from 1001.0 s to 1.0 s')
    assert found.counts['reset'] == 1


def test_how_far_ahead_is_too_far_grows_with_the_interval() -> None:
    quick, slow, told = intake(), intake(), intake(longest_gap=2.5)
    assert push(quick, 0.01, 0.02, 0.03, 10.5) == [0.01, 0.02, 0.03]
    assert push(slow, 30, 60, 90, 20_000) == [30, 60, 90, 20_000]
    assert push(told, 1, 2, 4.4, 7) == [1, 2, 4.4]


def test_a_plant_slower_than_any_guess_is_believed_and_then_known() -> None:
    found = intake()
    hours = [3600.0 * k for k in range(1, 12)]
    taken = []
    for t in hours:
        found.push(Sample(round(t * S), u=FEED))
        taken += push(found, t)
    assert taken[-6:] == hours[-6:]
    assert found.counts['reset'] <= 2


def test_inputs_without_an_end_do_not_fill_the_memory() -> None:
    found = intake()
    push(found, 0.5)
    for k in range(1, MOST + 101):
        found.push(Sample(S + k, u=FEED + k))
    assert found.counts['overflow'] == 101
    path = found.inputs.path(S // 2, 2 * S)
    assert path.pieces == MOST + 1
    assert path.u[path.pieces].tolist() == (FEED + MOST + 100).tolist()


def test_every_reason_is_explained() -> None:
    assert set(intake().counts) == set(COUNTS)
    assert all(COUNTS.values())
