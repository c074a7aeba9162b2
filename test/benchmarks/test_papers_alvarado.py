"""Observers of a tyre's stiffness on made-up runs; the acceptance fails what fails."""

import numpy as np
import pytest

from benchmarks.h_infinity import report as h_infinity
from benchmarks.h_infinity import run as tyre_runs
from obs_ros import Outcome, load_observer
from obs_ros.models.suspension import KT

SURE = tyre_runs.Window(30.0, 0.01, 0.01 * KT, Outcome.CONVERGED)


SILENT = tyre_runs.Window(30.0, 0.5, np.nan, Outcome.NOT_IDENTIFIABLE)


WRONG = tyre_runs.Window(30.0, 0.5, 0.01 * KT, Outcome.CONVERGED)


def tyre_acceptance(rms: float, near: float, *windows: tyre_runs.Window) -> list[bool]:
    """Of runs that are all alike, but for one that is better."""
    found = tyre_runs.Measured(rms, near, True, windows)
    runs = {
        (one.label, case.label): [found, found._replace(rms=0.1)]
        for one in tyre_runs.CONTESTANTS
        for case in tyre_runs.CASES
    }
    return [one.met for one in h_infinity.acceptance(runs, runs)]


@pytest.mark.parametrize(('rms', 'near', 'missed'), [(2.0, 0.3, 0), (3.0, 0.3, 2), (5.0, 1.2, 6)])
def test_acceptance_of_the_tyre_fails_what_is_missed(rms: float, near: float, missed: int) -> None:
    met = tyre_acceptance(rms, near, SURE)
    assert met.count(False) == missed
    assert met.count(True) == 19 - missed


def test_windows_on_the_cosine_may_be_off_if_they_withhold() -> None:
    """The others, and both kinds of windows on the trapezoid, may not: 3 and 4 of 19."""
    assert tyre_acceptance(9.0, 0.3, SILENT).count(False) == 7
    # Off and confident: all four rows of the cosine, and all four about that.
    assert tyre_acceptance(9.0, 0.3, WRONG).count(False) == 15
    assert WRONG.confidently_wrong
    assert not SURE.confidently_wrong and not SILENT.confidently_wrong


def test_windows_blind_to_eta_run_where_the_specification_has_them() -> None:
    found = [one.label for case in tyre_runs.CASES for one in tyre_runs.contestants(case)]
    assert found.count(tyre_runs.BLIND) == 4
    assert len(found) == 6 * 7 + 4
    assert tyre_runs.BLIND not in [
        one.label for one in tyre_runs.contestants(tyre_runs.CASES[1], tyre_runs.LONG)
    ]


def test_medians_and_extremes_are_told_apart() -> None:
    assert h_infinity.spread([1.0, 2.0, 9.0]) == '2.00 (9.00)'
    assert h_infinity.spread([1.0, np.inf, np.inf]) == 'never (never)'


def test_every_contestant_is_an_observer_with_settings_that_it_takes() -> None:
    for one in tyre_runs.CONTESTANTS:
        load_observer(one.observer)('suspension', **one.settings)
