"""Tests of obs_ros.horizon.announcements."""

import math
from dataclasses import replace

import numpy as np
import pytest
from exchanger import AT_REST
from jump_windows import record, still

from obs_ros import Estimate, Outcome, Sample
from obs_ros.core.estimate import Jump
from obs_ros.horizon.announcements import Announcements, AnnouncementSettings
from obs_ros.horizon.beliefs import Belief, Beliefs, jump_among
from obs_ros.horizon.found_jumps import JumpFound, Size, together
from obs_ros.observers.sliding_window import SlidingWindowObserver
from plant_sim.scenarios import load_scenario
from plant_sim.scenarios.heat_exchanger import NOMINAL
from plant_sim.signals import Schedule
from plant_sim.simulation import Simulation

SIGMA, PERIOD = 0.05, 0.05  # K, s
FAULT, END = 16.0, 22.0  # s


def valve_fault(seed: int) -> list[Estimate]:
    """Windows of 4 s, every 0.5 s, of a run in which dP1 falls at 16 s."""
    after = (NOMINAL[0] - 2e5, *NOMINAL[1:])
    scenario = replace(
        load_scenario('heat_exchanger_case1'),
        initial_state=AT_REST,
        parameters=Schedule((0.0, FAULT), (NOMINAL, after)),
        noise_correlation=0.1,
    )
    simulation = Simulation(scenario, period=PERIOD, seed=seed, snr_db=-20.0 * math.log10(SIGMA))
    observer = SlidingWindowObserver(
        'heat_exchanger_reduced', duration=4.0, period=0.5, noise={'Tp': SIGMA, 'Tu': SIGMA},
        process_noise='off',  # which takes correlated noise for walks, and hides the jump there
    )  # fmt: skip
    found = []
    for _ in range(round(END / PERIOD) + 1):
        instant = simulation.sample()
        sample = Sample(round(instant.t * 1e9), y=np.array(instant.y), u=np.array(instant.u))
        if observer.absorb(sample) and (estimate := observer.estimate()):
            found.append(estimate)
    return found


@pytest.mark.parametrize('seed', [102, pytest.param(106, marks=pytest.mark.slow)])
def test_one_jump_is_announced_once_whichever_of_two_names_it_has(seed: int) -> None:
    """With these noises windows after the first call it dP1, k1 and dP1 again.

    Later windows may correct it, once the odds are clear: what is taken back is announced anew.
    """
    shown = [
        jump for one in valve_fault(seed) for jump in one.jumps if abs(jump.time - FAULT) < 1.0
    ]
    assert {together(jump.sizes) for jump in shown} >= {'dP1', 'k1'}
    assert sum(jump.new for jump in shown if not jump.retracted) - 1 == sum(
        jump.retracted for jump in shown
    )
    inside = [jump for jump in shown if jump.time > FAULT - 0.5 and not jump.retracted]
    assert all(0.0 < jump.probability <= 1.0 for jump in inside)


DURATION = 10.0  # s
WINDOW = still(record())
Lineages = dict[tuple[JumpFound, ...], float]  # probabilities


class Found(JumpFound):
    """A jump found that may be a key."""

    def __hash__(self) -> int:
        return hash(self.time)


def jump(time: float, *names: str, clear: bool = True) -> Found:
    size = Size(0.5, 0.1, 0.5, 0.05 if clear else 0.3)
    return Found(time, 0.1, dict.fromkeys(names, size))


class Story:
    """Windows of 10 s, whose beliefs are told, the most probable lineage first."""

    def __init__(self) -> None:
        self.announcements = Announcements()

    def window(
        self, start: float, lineages: Lineages | None = None, *, given: bool = True,
        explained: bool = True, alone: bool = True, moving: tuple[str, ...] = (),
        still: float | None = None,
    ) -> Estimate:  # fmt: skip
        """The estimate of the next window; `given`: its deviations are."""
        every = []
        for jumps, weight in (lineages or {(): 1.0}).items():
            own = tuple(one for one in jumps if one.time > start)
            every.append(Belief(weight, WINDOW, jumps, own))
        none = sum(one.weight for one in every if not one.own) if still is None else still
        beliefs = Beliefs(tuple(every), start, DURATION, none)
        shown = [jump_among(one, beliefs.chances(one), start + 10.0, None) for one in every[0].own]
        estimate = Estimate(
            {'h': 1.0, 'l': 1.0}, {}, {}, dict.fromkeys('hl', 0.1 if given else np.nan),
            Outcome.CONVERGED, 'well', start, start + DURATION, jumps=tuple(shown),
        )  # fmt: skip
        return self.announcements.announced(
            estimate, beliefs, explained=explained, alone=alone, moving=moving
        )

    def calm(self, *starts: float) -> None:
        for start in starts:
            assert self.window(start).jumps == ()


def news(estimate: Estimate) -> list[Jump]:
    return [jump for jump in estimate.jumps if jump.new]


H, L, BOTH = jump(25.0, 'h'), jump(25.1, 'l'), jump(25.0, 'h', 'l')


def test_a_clear_jump_is_announced_once_with_its_probability() -> None:
    story = Story()
    story.calm(0.0, 10.0)
    first = story.window(18.0, {(H,): 0.9, (L,): 0.1})
    (one,) = news(first)
    assert one.sizes == {'h': 0.5} and one.probability == pytest.approx(0.9)
    assert one.alternatives == ('l',)
    # A superset, then the subset again: one jump.
    assert news(story.window(19.0, {(BOTH,): 0.6, (H,): 0.4})) == []
    assert news(story.window(20.0, {(H,): 1.0})) == []
    assert news(story.window(30.0, {(H,): 1.0})) == []


@pytest.mark.parametrize(('doubt', 'announced'), [(0.06, False), (0.04, True)])
def test_none_is_announced_while_none_may_be(doubt: float, announced: bool) -> None:
    story = Story()
    story.calm(0.0, 10.0)
    assert bool(news(story.window(20.0, {(H,): 1.0 - doubt, (): doubt}))) == announced


def test_one_that_is_not_clear_is_none() -> None:
    story = Story()
    story.calm(0.0, 10.0)
    assert news(story.window(20.0, {(jump(25.0, 'h', clear=False),): 1.0})) == []


@pytest.mark.parametrize('kept', [{'given': False}, {'explained': False}])
def test_windows_that_are_not_believed_announce_nothing(kept: dict[str, bool]) -> None:
    story = Story()
    story.calm(0.0, 10.0)
    assert news(story.window(20.0, {(H,): 1.0}, **kept)) == []
    # Nor does a later one that has it from there.
    assert news(story.window(30.0, {(H,): 1.0})) == []


def test_in_the_first_window_nobody_knows_whether_jumps_are_rare() -> None:
    story = Story()
    assert news(story.window(0.0, {(jump(5.0, 'h'),): 1.0})) == []
    (late,) = news(story.window(10.0, {(jump(5.0, 'h'),): 1.0}))
    assert late.time == 5.0


def test_doubt_that_ends_later_makes_the_announcement_late() -> None:
    story = Story()
    story.calm(0.0, 10.0)
    assert news(story.window(20.0, {(): 0.6, (H,): 0.4})) == []
    (late,) = news(story.window(30.0, {(H,): 0.97, (): 0.03}))
    assert (late.time, late.probability) == (25.0, pytest.approx(0.97))
    assert news(story.window(40.0, {(H,): 1.0})) == []


@pytest.mark.parametrize(('odds', 'turned'), [(2.5, False), (3.5, True)])
def test_a_jump_is_taken_back_when_the_evidence_turns(odds: float, turned: bool) -> None:
    story = Story()
    story.calm(0.0, 10.0)
    (announced,) = news(story.window(20.0, {(H,): 0.98, (): 0.02}))
    found = story.window(30.0, {(): odds / (1.0 + odds), (H,): 1.0 / (1.0 + odds)})
    assert bool(news(found)) == turned
    if turned:
        (retraction,) = news(found)
        assert retraction.retracted and retraction.takes_back(announced)
        assert retraction.sizes == {'h': 0.0}
        assert 'taken back' in found.message
        assert news(story.window(40.0)) == []


def test_another_set_that_is_clearly_likelier_is_announced_instead() -> None:
    story = Story()
    story.calm(0.0, 10.0)
    (announced,) = news(story.window(20.0, {(H,): 0.6, (L,): 0.4}))
    retraction, instead = news(story.window(30.0, {(L,): 0.8, (H,): 0.2}))
    assert retraction.takes_back(announced)
    assert instead.sizes == {'l': 0.5} and not instead.retracted
    assert (instead.time, instead.probability) == (25.1, pytest.approx(0.8))
    assert instead.alternatives == ('h',)


def test_a_window_that_begins_just_before_a_jump_takes_nothing_back() -> None:
    for start, turned in ((24.0, False), (23.0, True)):
        story = Story()
        story.calm(0.0, 10.0)
        assert news(story.window(20.0, {(H,): 1.0}))
        assert bool(news(story.window(start))) == turned


def test_jumps_in_most_windows_are_a_drift() -> None:
    story = Story()
    story.calm(0.0)
    announced, drifting = 0, []
    for k in range(1, 12):
        found = story.window(10.0 * k, {(jump(10.0 * k + 5.0, 'h'),): 1.0})
        announced += len(news(found))
        drifting.append(found.drifting)
    assert announced == 2, 'two faults in a row are no drift'
    assert drifting == [(), ()] + [('h',)] * 9
    assert 'walk.h' in found.message
    # Half a box in every window of 10 s, over nine windows.
    jumps = 11
    assert story.announcements.rates == {'h': pytest.approx(0.25 * jumps / 90.0)}
    # When it is over, jumps are jumps again, and old ones none.
    for k in range(12, 25):
        found = story.window(10.0 * k)
        assert news(found) == []
    assert found.drifting == () and story.announcements.rates == {}
    assert len(news(story.window(250.0, {(jump(255.0, 'h'),): 1.0}))) == 1


@pytest.mark.parametrize(('moving', 'announced'), [('h', True), ('l', False)])
def test_a_jump_that_a_window_before_could_not_date_counts_once(
    moving: str, announced: bool
) -> None:
    """The next one takes it for its own start, and announces it."""
    story = Story()
    story.calm(0.0, 10.0)
    for start in (20.0, 30.0):
        assert story.window(start, moving=(moving,), alone=False).drifting == ()
    told = story.window(40.0, {(jump(40.2, 'h'),): 1.0})
    assert bool(news(told)) == announced
    assert bool(told.drifting) != announced


def test_overlapping_windows_count_once() -> None:
    """A jump that stands in all of them is one."""
    story = Story()
    story.calm(0.0, 10.0)
    for start in np.arange(16.0, 25.0, 1.0):
        found = story.window(float(start), {(H,): 1.0})
        assert found.drifting == ()


def test_what_is_not_constant_beside_process_noise_drifts_too() -> None:
    story = Story()
    for k in range(6):
        found = story.window(10.0 * k, alone=False, moving=('l',) if k % 2 else ())
    assert found.drifting == ('l',)


@pytest.mark.parametrize(('still', 'announced'), [(1e-8, False), (1e-9, True)])
def test_beside_process_noise_a_jump_must_be_sure(still: float, announced: bool) -> None:
    story = Story()
    for k in range(3):
        story.window(10.0 * k, alone=False)
    found = story.window(30.0, {(jump(35.0, 'h'),): 1.0}, alone=False, still=still)
    assert bool(news(found)) == announced
    assert AnnouncementSettings().doubt_pushed == 2e-9
