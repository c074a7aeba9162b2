"""Tests of obs_ros.observers.papers.gase."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from passino import PERIOD, follow, played

from obs_ros import Sample
from obs_ros.models import load_model
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.papers.gase import GeneticAdaptiveStateEstimator, compact
from plant_sim.simulation import Instant

LINEAR = 'observer_form_third_order'
SMALL: dict[str, Any] = {
    'population': 40, 'parents': 14, 'elite': 3, 'window': 50, 'generations': 4
}  # fmt: skip


@pytest.fixture(scope='module')
def linear() -> list[Instant]:
    return played(LINEAR, 800)


@pytest.mark.parametrize('mode', ['window_end', 'paper'])
def test_its_states_follow_the_plant(mode: str, linear: list[Instant]) -> None:
    found = follow(GeneticAdaptiveStateEstimator(LINEAR, mode=mode), linear)
    x = np.array([list(e.state.values()) for e in found])
    truth = np.array([instant.x for instant in linear])
    assert np.abs(x[100:, 0] - truth[100:, 0]).max() < 0.01
    # Of states of +-3: the paper's means are 4329 and 2008 over 10000 samples.
    assert ((x - truth)[:, 1:] ** 2).mean(axis=0).max() < 1.0
    assert truth[:, 1:].std(axis=0).min() > 0.9


def test_parameters_stay_within_their_bounds_and_digits(linear: list[Instant]) -> None:
    found = follow(GeneticAdaptiveStateEstimator(LINEAR, **SMALL), linear[:120])
    model = load_model(LINEAR)
    for variable in model.parameters:
        values = np.array([e.parameters[variable.name] for e in found[1:]])
        assert values.min() >= variable.lower and values.max() <= variable.upper
        np.testing.assert_allclose(1e4 * values, np.rint(1e4 * values), atol=1e-7)
        assert values.std() > 0.0


def test_a_fast_parameter_is_found_where_the_window_tells_it(linear: list[Instant]) -> None:
    others = {'a2': 2.1, 'a1': 2.1, 'a0': 1.0, 'b1': 0.9, 'b0': 0.8}
    observer = GeneticAdaptiveStateEstimator(LINEAR, fixed=others, mode='window_end', **SMALL)
    found = follow(observer, linear[:300])
    assert found[-1].parameters == pytest.approx({**others, 'b2': 1.0}, abs=0.02)  # Euler's
    assert found[-1].state['x2'] == pytest.approx(linear[299].x[1], abs=0.05)


def test_figures_tell_cost_and_generation(linear: list[Instant]) -> None:
    found = follow(GeneticAdaptiveStateEstimator(LINEAR, **SMALL), linear[:60])
    assert [e.figures.get('generation', 0.0) for e in found] == [4.0 * k for k in range(60)]
    assert 0.0 < found[-1].figures['cost'] < 0.01
    noisy = follow(GeneticAdaptiveStateEstimator(LINEAR, noise={'x1': 0.1}, **SMALL), linear[:60])
    assert noisy[-1].figures['cost'] == pytest.approx(100.0 * found[-1].figures['cost'])


def test_the_cost_is_that_of_the_papers_window(linear: list[Instant]) -> None:
    """Forward Euler from (y, xhat2, xhat3) at k - W - 1, x1 measured anew before every step."""
    window = 5
    observer = GeneticAdaptiveStateEstimator(LINEAR, **{**SMALL, 'window': window})
    found = follow(observer, linear[:30])
    a2, a1, a0, b2, b1, b0 = found[-1].parameters.values()
    first = 29 - window - 1
    x = np.array(list(found[first].state.values()))
    cost = 0.0
    for j in range(first, 29):
        x[0] = linear[j].y[0]
        u = 0.5 * (linear[j].u[0] + linear[j + 1].u[0])  # it runs on between samples
        rates = np.array([x[1] - a2 * x[0] + b2 * u, x[2] - a1 * x[0] + b1 * u, b0 * u - a0 * x[0]])
        x = x + 0.01 * rates
        cost += (linear[j + 1].y[0] - x[0]) ** 2
    assert found[-1].figures['cost'] == pytest.approx(cost, rel=1e-9)
    np.testing.assert_allclose(list(found[-1].state.values()), x, rtol=1e-9)


def test_in_the_papers_mode_the_state_takes_one_step_under_the_input_before(
    linear: list[Instant],
) -> None:
    found = follow(GeneticAdaptiveStateEstimator(LINEAR, mode='paper', **SMALL), linear[:80])
    a1, b1 = (found[-1].parameters[name] for name in ('a1', 'b1'))
    x = found[-2].state
    step = x['x2'] + 0.01 * (x['x3'] - a1 * linear[78].y[0] + b1 * linear[78].u[0])
    assert found[-1].state['x2'] == pytest.approx(step, rel=1e-12)


def test_stall_of_a_jet_engine_is_seen_and_never_negative() -> None:
    instants = played('jet_engine_case1', 1200)
    observer = GeneticAdaptiveStateEstimator('jet_engine', population=60, parents=20, elite=4)
    found = follow(observer, instants)
    r = np.array([e.state['R'] for e in found])
    truth = np.array([instant.x[1] for instant in instants])
    assert r.min() >= 0.0
    assert truth[-1] > 0.5 > 0.1 > truth[400]
    assert r[-1] == pytest.approx(truth[-1], abs=0.1)


def test_the_same_seed_gives_the_same_bits_and_another_others(linear: list[Instant]) -> None:
    a, b, c = (
        follow(GeneticAdaptiveStateEstimator(LINEAR, seed=seed, **SMALL), linear[:60])[-1]
        for seed in (3, 3, 4)
    )
    assert (a.parameters, a.state) == (b.parameters, b.state)
    assert a.parameters != c.parameters


def test_numpy_and_numba_breed_the_same_candidates(linear: list[Instant]) -> None:
    a, b = (
        follow(GeneticAdaptiveStateEstimator(LINEAR, backend=name, **SMALL), linear[:25])
        for name in ('numba', 'numpy')
    )
    assert a[-1].parameters == b[-1].parameters
    assert a[-1].state == pytest.approx(b[-1].state, rel=1e-9)


def test_parameters_between_which_others_are_given_are_estimated(linear: list[Instant]) -> None:
    assert compact(np.array([1, 2, 3])) == slice(1, 4)
    model = load_model(LINEAR)
    wanted = ('a2', 'a0', 'b0')
    observer = GeneticAdaptiveStateEstimator(model, parameters=wanted, seed=1, **SMALL)
    estimate = follow(observer, linear[:60])[-1]
    nominal = {variable.name: variable.nominal for variable in model.parameters}
    moved = {name for name, value in estimate.parameters.items() if value != nominal[name]}
    assert moved == set(wanted)


def test_missing_outputs_are_bridged(linear: list[Instant]) -> None:
    rng = np.random.default_rng(5)
    gaps = [replace(i, y=(np.nan,)) if rng.random() < 0.3 else i for i in linear[:200]]
    observer = GeneticAdaptiveStateEstimator(LINEAR, **SMALL)
    for k, instant in enumerate(gaps):
        observer.absorb(Sample(k * PERIOD, y=np.array(instant.y), u=np.array(instant.u)))
    found = observer.estimate()
    assert found.usable
    assert observer.counts['reset_non_finite'] == 0
    assert found.state['x1'] == pytest.approx(linear[199].x[0], abs=0.05)


@pytest.mark.parametrize(
    ('model', 'arguments', 'message'),
    [
        (LINEAR, {'mode': 'window'}, "unknown mode 'window': did you mean 'window_end'?"),
        (LINEAR, {'parents': 201}, 'parents 201 are more than the population of 200'),
        (LINEAR, {'elite': 200}, 'elite 200 leaves no room'),
        (LINEAR, {'mutation': 0.0}, 'mutation must be > 0, <= 1, not 0.0'),
        (LINEAR, {'window': 0}, 'window must be 1 to 10000, not 0'),
        (LINEAR, {'parameters': ()}, 'needs a parameter to estimate'),
        (LINEAR, {'bounds': {'b2': (0.0, np.inf)}}, 'b2 needs finite bounds, not 0.0 to inf'),
    ],
)
def test_wrong_settings_are_named(model: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        GeneticAdaptiveStateEstimator(model, **arguments)


def test_a_model_with_an_output_that_is_no_state_is_refused() -> None:
    model = replace(THREE_TANK, output=lambda t, x, u, p: (x[0] + x[1], x[2]))
    with pytest.raises(ValueError, match='output h1 is none of the states'):
        GeneticAdaptiveStateEstimator(model)
