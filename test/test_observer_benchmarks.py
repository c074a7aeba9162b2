"""What the benchmarks of the observers measure, on made-up runs, and that they fail what fails."""

import numpy as np
import pytest

from benchmarks import flow_runs, h_infinity, interconnected, tyre_runs
from benchmarks.flow_runs import CONTESTANTS, Found, Measured, named_valves, settling
from benchmarks.observer_costs import FORM, SCENARIOS, WINDOW, played
from obs_ros import load_model, load_observer
from obs_ros.observers import OBSERVERS
from plant_sim.scenarios import load_scenario


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


def runs_of(rms: float, settled: float) -> tuple[interconnected.Runs, interconnected.Runs]:
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
    text = interconnected.acceptance(*runs_of(rms, settled))
    assert text.count('**no**') == missed
    assert text.count('| yes |') == 5 - missed


def test_a_wrong_name_or_a_nan_fails_its_acceptance() -> None:
    quiet, noisy = runs_of(0.7, 0.5)
    bad = noisy['interconnected, theta 2', 2][0]._replace(named=(False, True), finite=False)
    noisy['interconnected, theta 2', 2][0] = bad
    assert interconnected.acceptance(quiet, noisy).count('**no**') == 2


@pytest.mark.parametrize(('rms', 'near', 'missed'), [(2.0, 0.3, 0), (3.0, 0.3, 2), (5.0, 1.2, 4)])
def test_acceptance_of_the_tyre_fails_what_is_missed(rms: float, near: float, missed: int) -> None:
    found = tyre_runs.Measured(rms, near, True)
    runs = {
        (one.label, case.label): [found, found._replace(rms=0.1)]
        for one in tyre_runs.CONTESTANTS
        for case in tyre_runs.CASES
    }
    text = h_infinity.acceptance(runs)
    assert text.count('**no**') == missed
    assert text.count('| yes |') == 5 - missed


def test_medians_and_extremes_are_told_apart() -> None:
    assert h_infinity.spread([1.0, 2.0, 9.0]) == '2.00 (9.00)'
    assert h_infinity.spread([1.0, np.inf, np.inf]) == 'never (never)'
    assert interconnected.beside('0.1 / 0.2', '') == '0.1 / 0.2'


def test_every_contestant_is_an_observer_with_settings_that_it_takes() -> None:
    from obs_ros import load_observer

    for one in flow_runs.CONTESTANTS:
        load_observer(one.observer)('heat_exchanger', **one.settings)
    for one in tyre_runs.CONTESTANTS:
        load_observer(one.observer)('suspension', **one.settings)


@pytest.mark.parametrize('name', OBSERVERS)
def test_every_observer_is_measured_on_a_scenario_that_suits_it(name: str) -> None:
    scenario = SCENARIOS.get(name, FORM)
    model = load_model(load_scenario(scenario).model)
    settings = WINDOW if name == 'sliding_window' else {}
    observer = load_observer(name)(model, **settings)
    samples, parameters = played(scenario, 3, seed=0)
    assert parameters.shape == (3, len(model.parameters))
    assert observer.absorb(samples[0]) == observer.immediate
