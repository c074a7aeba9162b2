"""Observers of the heat exchanger's flows on made-up runs; the acceptance fails what fails."""

import numpy as np
import pytest

from benchmarks.interconnected import report as interconnected
from benchmarks.interconnected import run as flow_runs
from benchmarks.interconnected import window_report as valve_tables
from benchmarks.interconnected.run import CONTESTANTS, Found, Measured, named_valves, settling
from benchmarks.interconnected.window_report import PRODUCT
from benchmarks.interconnected.windows import (
    NOISES,
    SIZES,
    WATCHES,
    Followed,
    Isolated,
    Watched,
    Windows,
    isolated,
    watched,
)
from obs_ros import load_observer


def test_settling_is_the_last_time_out_of_the_band() -> None:
    t = np.arange(0.0, 10.0, 0.5)
    error = np.where(t < 3.0, 0.1, 0.0)
    error[t == 6.0] = -0.021
    assert settling(t, error, 1.0, 10.0) == 5.0
    assert settling(t, error, 1.0, 6.0) == 1.5
    assert settling(t, error, 7.0, 10.0) == 0.0


def test_the_valve_is_named_whose_residual_changed_most() -> None:
    t = np.arange(70.0, 180.0, 0.1)
    residuals = np.zeros((t.size, 2))
    residuals[t >= 80.5, 1] = 0.22
    residuals[t >= 150.5, 0] = 0.16  # less than the other one has been since 80 s
    run = Found(t, np.ones_like(residuals), np.ones_like(residuals), residuals)
    assert named_valves(run) == (True, True)
    assert named_valves(run._replace(residuals=residuals[:, ::-1])) == (False, False)


def runs_of(rms: float, settled: float) -> tuple[flow_runs.Runs, flow_runs.Runs]:
    """Runs that are all alike, but for case 3, where feeding the model divides the error by 10."""
    good = Measured(np.full(2, settled), np.full(2, rms), (True, True), 5.0, True)
    quiet = {(one.label, case): [good] for one in CONTESTANTS for case in (1, 2)}
    noisy = {(one.label, 2): [good, good] for one in CONTESTANTS}
    for one in CONTESTANTS:
        share = 0.1 if one.observer == 'interconnected' else 1.0
        noisy[one.label, 3] = [good._replace(rms=share * good.rms)]
    return quiet, noisy


@pytest.mark.parametrize(
    ('rms', 'settled', 'missed'), [(0.7, 0.5, 0), (0.9, 0.5, 1), (0.7, 0.6, 1), (3.0, 1.0, 2)]
)
def test_acceptance_of_the_flows_fails_what_is_missed(
    rms: float, settled: float, missed: int
) -> None:
    met = [one.met for one in interconnected.acceptance(*runs_of(rms, settled))]
    assert met.count(False) == missed
    assert met.count(True) == 5 - missed


def test_a_wrong_name_or_a_nan_fails_its_acceptance() -> None:
    quiet, noisy = runs_of(0.7, 0.5)
    bad = noisy['interconnected, theta 2', 2][0]._replace(named=(False, True), finite=False)
    noisy['interconnected, theta 2', 2][0] = bad
    assert [one.met for one in interconnected.acceptance(quiet, noisy)].count(False) == 2


GOOD = Isolated(True, True, True, 0.1, 0.5, 0)


CLEAN = Watched(
    p_error=np.full((100, 4), 0.01),
    p_sd=np.full((100, 4), 0.01),
    x_error=np.full((100, 4), 0.01),
    x_sd=np.full((100, 4), 0.01),
    weak=(('only dP1/k1^2 is determined (known from earlier windows)',),) * 100,
    alarms=0,
)


def windows_of(error: float = 0.004, fault: Isolated = GOOD, clean: Watched = CLEAN) -> Windows:
    """Windows that are all alike, but for the one fault and clean run given."""
    t = np.arange(74.0, 180.0, 0.5)
    run = Followed(t, np.full((t.size, 2), error), np.tile([5e3, 25.0], (t.size, 1)))
    quiet = run._replace(error=0.0 * run.error)
    faults = {noise: {name: [GOOD] * 5 for name in ('dP1', 'k1')} for noise in NOISES}
    faults['0.1 K, white']['k1'] = [fault] + [GOOD] * 4
    watches = {label: [CLEAN] for label in WATCHES}
    watches['pressures move, all four unknown'] = [clean]
    return Windows(quiet, [run], faults, watches)


@pytest.mark.parametrize(
    ('windows', 'missed'),
    [
        (windows_of(), 0),
        (windows_of(error=0.007), 1),
        (windows_of(fault=GOOD._replace(named=False)), 1),
        (windows_of(fault=GOOD._replace(partner=False)), 1),
        (windows_of(clean=CLEAN._replace(p_error=np.full((100, 4), 0.021))), 1),
        (windows_of(clean=CLEAN._replace(x_error=np.full((100, 4), 0.04))), 1),
    ],
)
def test_acceptance_of_windows_fails_what_is_missed(windows: Windows, missed: int) -> None:
    met = [one.met for one in valve_tables.window_acceptance(windows)]
    assert met.count(False) == missed
    tables = valve_tables.window_tables(windows)
    assert all('| --- |' in str(tables[name]) for name in ('followed', 'faults', 'watches'))


def test_words_that_are_missing_or_wrong_are_counted() -> None:
    half = CLEAN._replace(weak=CLEAN.weak[:50] + (('only dP1/k1 is determined',),) * 50)
    assert valve_tables.named([half]) == 0.5
    silent = CLEAN._replace(p_sd=np.full((100, 4), np.nan), p_error=np.full((100, 4), 0.5))
    assert valve_tables.wrong([silent]) == 0.0
    assert valve_tables.withheld([silent]) == 1.0


def test_a_reference_stands_in_brackets() -> None:
    assert interconnected.beside('0.1 / 0.2', '') == '0.1 / 0.2'
    assert interconnected.beside('0.1', '0.2') == '0.1 (0.2)'


def test_every_contestant_is_an_observer_with_settings_that_it_takes() -> None:
    for one in flow_runs.CONTESTANTS:
        load_observer(one.observer)('heat_exchanger', **one.settings)


@pytest.mark.slow
@pytest.mark.parametrize('parameters', [('dP1', 'k1'), ('dP1', 'dP2', 'k1', 'k2')])
def test_at_constant_pressures_only_products_are_claimed(parameters: tuple[str, ...]) -> None:
    found = watched(moving=False, seed=3, parameters=parameters)
    assert all(any(text.startswith(PRODUCT) for text in weak) for weak in found.weak)
    assert np.isnan(found.p_sd).all()
    # The flows, and with them the temperatures, are known all the same.
    assert np.isfinite(found.x_sd[:, :2]).all()
    assert (np.abs(found.x_error[:, :2]) < 3.5 * found.x_sd[:, :2]).all()
    assert found.alarms == 0


@pytest.mark.slow
@pytest.mark.parametrize('parameter', SIZES)
def test_a_fault_names_its_valve_within_two_seconds(parameter: str) -> None:
    found = isolated(parameter, sigma=0.05, correlation=0.1, seed=3)
    assert found.named
    assert found.partner
    assert abs(found.error) < 0.5
    assert found.false == 0
