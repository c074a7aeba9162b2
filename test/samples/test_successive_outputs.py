"""Tests of obs_ros.samples.successive_outputs."""

import numpy as np
from plants import BLOW_UP, VESSEL

from obs_ros import Sample
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.samples.gate import GateSettings
from obs_ros.samples.stuck_sensor import Repeats, StuckSettings
from obs_ros.samples.successive_outputs import COUNTS, SuccessiveOutputs

S = 10**9
FEED, LEVELS = np.array([30.0, 30.0]), np.array([1.0, 2.0])
NAN = np.nan


def tanks(known_noise: bool | None = None, capacity: int = 4096) -> SuccessiveOutputs:
    repeats = None if known_noise is None else Repeats([known_noise] * 2)
    found = SuccessiveOutputs(THREE_TANK, GateSettings(), repeats, capacity)
    found.push(Sample(0, u=FEED))
    return found


def push(found: SuccessiveOutputs, *seconds: float, y: np.ndarray = LEVELS) -> list[float]:
    """Push outputs; return the times of those handed out."""
    due = []
    for t in seconds:
        found.push(Sample(round(t * S), y=y))
        due += [stamp / S for stamp, _ in found.due]
    return due


def test_outputs_come_out_once_and_in_order() -> None:
    found = tanks()
    assert push(found, 1, 2, 2, 1, 3, 2.5, 4) == [1, 2, 3, 4]
    assert (found.counts['duplicate'], found.counts['late']) == (1, 2)


def test_five_samples_back_in_time_start_it_anew_and_none_of_them_is_lost() -> None:
    found = tanks()
    found.push(Sample(1000 * S, u=FEED))
    push(found, 1000, 1001)
    found.push(Sample(0, u=FEED))  # not newer than the input known: a suspect as well
    assert push(found, 1, 2, 3, 4) == []
    assert found.push(Sample(5 * S, y=LEVELS))
    assert [stamp / S for stamp, _ in found.due] == [1, 2, 3, 4, 5]


def test_outputs_before_every_input_is_known_are_early() -> None:
    found = SuccessiveOutputs(THREE_TANK, GateSettings())
    assert push(found, 1) == []
    found.push(Sample(2 * S, u=np.array([30.0, NAN])))
    assert push(found, 3) == []
    found.push(Sample(4 * S, u=np.array([NAN, 20.0])))
    assert push(found, 4) == [4]
    assert found.counts['early'] == 2
    assert found.inputs.path(4 * S, 5 * S).u[0].tolist() == [30.0, 20.0]


def test_an_output_before_all_that_were_early_is_sorted_in_and_comes_once() -> None:
    found = SuccessiveOutputs(VESSEL, GateSettings())
    one = np.ones(1)
    assert push(found, 1, 3, y=one) == []
    found.push(Sample(0, u=one))
    assert push(found, 2, 2, 1.5, 4, y=one) == [2, 4]
    counts = found.counts
    assert (counts['early'], counts['reordered']) == (2, 1)
    assert (counts['duplicate'], counts['late']) == (1, 1)


def test_a_late_input_is_sorted_in_or_in_force_from_the_last_output_on() -> None:
    found = SuccessiveOutputs(VESSEL, GateSettings())
    for t, u in ((0, 0.0), (6, 6.0), (4, 4.0)):
        found.push(Sample(t * S, u=np.array([u])))
    push(found, 1, 3, y=np.ones(1))
    found.push(Sample(2 * S, u=np.array([2.0])))
    assert (found.counts['reordered'], found.counts['late']) == (1, 1)
    path = found.inputs.path(3 * S, 7 * S)
    assert path.t[:4].tolist() == [3, 4, 6, 7]
    assert path.u[:4, 0].tolist() == [2, 4, 6, 6]


def test_inputs_without_an_end_do_not_fill_the_memory() -> None:
    found = tanks(capacity=100)
    push(found, 0.5)
    for k in range(1, 151):
        found.push(Sample(S + k, u=FEED + k))
    assert found.counts['overflow'] == 51
    path = found.inputs.path(S // 2, 2 * S)
    assert path.pieces == 101
    assert path.u[0].tolist() == (FEED + 51).tolist()
    assert path.u[path.pieces].tolist() == (FEED + 150).tolist()


def test_what_a_stuck_sensor_repeats_is_not_measured() -> None:
    enough = StuckSettings().repeats
    one, all_of_them, unheard = tanks(False), tanks(True), tanks()
    for k in range(1, enough + 3):
        one.push(Sample(k * S, y=np.array([5.0, float(k)])))
        all_of_them.push(Sample(k * S, y=LEVELS))
        unheard.push(Sample(k * S, y=LEVELS))
    assert [counts['stuck'] for counts in (one.counts, all_of_them.counts, unheard.counts)] == [
        3, 3, 0
    ]  # fmt: skip
    ((_, y),) = one.due
    assert np.isnan(y[0]) and y[1] == enough + 2
    assert all_of_them.due == [] and len(unheard.due) == 1


def test_a_reset_forgets_all_but_the_counts() -> None:
    found = tanks()
    push(found, 1, 1)
    found.reset()
    assert push(found, 2) == [] and found.passed is None
    assert (found.counts['duplicate'], found.counts['early']) == (1, 1)


def test_a_plant_without_inputs_knows_all_of_them() -> None:
    found = SuccessiveOutputs(BLOW_UP, GateSettings())
    assert push(found, 1, 2, y=np.ones(1)) == [1, 2]


def test_every_reason_is_explained() -> None:
    assert set(tanks().counts) == set(COUNTS)
    assert all(COUNTS.values())
