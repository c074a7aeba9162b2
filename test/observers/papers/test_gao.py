"""Tests of obs_ros.observers.papers.gao."""

import re
from typing import Any

import numpy as np
import pytest
from passino import follow, played

from obs_ros.observers.papers.gao import GeneticAdaptiveObserver
from plant_sim.simulation import Instant

LINEAR = 'linear_second_order'
OSCILLATOR = 'glycolytic_oscillator'
# Section 4.2 of the paper; its constants for the linear plant are the defaults.
NONLINEAR: dict[str, Any] = {
    'least_gains': (0.0, -9.9), 'most_gains': (9.9, -0.01), 'alpha2': 80.0, 'tolerance': 5e-5
}  # fmt: skip


def errors(found: Any, instants: list[Instant]) -> Any:
    x = np.array([list(e.state.values()) for e in found])
    return x - np.array([instant.x for instant in instants])


@pytest.fixture(scope='module')
def linear() -> list[Instant]:
    return played(LINEAR, 1001)


@pytest.fixture(scope='module')
def oscillator() -> list[Instant]:
    return played(OSCILLATOR, 2001)


@pytest.mark.parametrize('seed', range(3))
def test_with_the_papers_freeze_the_linear_plant_settles(seed: int, linear: list[Instant]) -> None:
    found = follow(GeneticAdaptiveObserver(LINEAR, freeze=True, seed=seed), linear)
    wrong = np.abs(errors(found, linear)[:, 1]) >= 0.05
    assert wrong[0] and not wrong[400:].any()
    frozen = np.array([e.figures['frozen'] for e in found])
    since = int(frozen.argmax())
    assert since > 200 and frozen[since:].all()
    gains = {(e.figures['L1'], e.figures['L2']) for e in found[since:]}
    assert len(gains) == 1
    before = np.array([[e.figures['L1'], e.figures['L2']] for e in found[since - 200 : since]])
    np.testing.assert_allclose(gains.pop(), before.mean(axis=0), rtol=1e-12)


def test_without_the_freeze_it_adapts_for_ever(oscillator: list[Instant]) -> None:
    found = follow(GeneticAdaptiveObserver(OSCILLATOR, **NONLINEAR), oscillator[:801])
    assert [e.figures['generation'] for e in found] == [float(k) for k in range(801)]
    assert not any(e.figures['frozen'] for e in found)
    late = np.array([e.figures['L2'] for e in found[-200:]])
    assert late.std() > 0.0


def test_x2_of_the_oscillator_is_as_near_as_specified(oscillator: list[Instant]) -> None:
    rms = []
    for seed in range(3):
        observer = GeneticAdaptiveObserver(OSCILLATOR, seed=seed, **NONLINEAR)
        x2 = errors(follow(observer, oscillator), oscillator)[:, 1]
        assert observer.counts['reset_non_finite'] == 0
        rms.append(np.sqrt((x2[1000:] ** 2).mean()))
    assert np.mean(rms) <= 0.08


def test_gains_stay_in_their_domain(oscillator: list[Instant]) -> None:
    found = follow(GeneticAdaptiveObserver(OSCILLATOR, **NONLINEAR), oscillator[:300])
    gains = np.array([[e.figures['L1'], e.figures['L2']] for e in found])
    assert gains[:, 0].min() >= 0.0 and gains[:, 0].max() <= 9.9
    assert gains[:, 1].min() >= -9.9 and gains[:, 1].max() <= -0.01


@pytest.mark.parametrize('a12', [-4.5, -3.0])
def test_step_and_fitness_are_those_of_equations_8_and_9(a12: float, linear: list[Instant]) -> None:
    found = follow(GeneticAdaptiveObserver(LINEAR, fixed={'a12': a12}), linear[:40])
    before, now = linear[38], linear[39]
    x = np.array(list(found[38].state.values()))
    gains = np.array([found[39].figures['L1'], found[39].figures['L2']])

    def f(x: Any, u: float) -> Any:
        return np.array([0.9775 * x[0] + 0.01 * a12 * x[1], 0.945 * x[1] + 0.01 * u])

    state = f(x, before.u[0]) + gains * (before.y[0] - x[0])
    np.testing.assert_allclose(list(found[39].state.values()), state, rtol=1e-12)
    p1 = now.y[0] - state[0]
    p2 = (f(state, now.u[0]) + gains * p1)[0] - now.y[0]
    assert found[39].figures['best_fitness'] == pytest.approx(-(5.0 * p1**2 + 40.0 * p2**2))
    assert found[39].residual_rms == pytest.approx(abs(p1))


def test_the_same_seed_gives_the_same_bits_and_another_others(linear: list[Instant]) -> None:
    a, b, c = (
        follow(GeneticAdaptiveObserver(LINEAR, seed=seed), linear[:60])[-1] for seed in (3, 3, 4)
    )
    assert (a.figures, a.state) == (b.figures, b.state)
    assert a.figures != c.figures


@pytest.mark.parametrize(
    ('model', 'arguments', 'message'),
    [
        ('three_tank', {}, "model 'three_tank' has 2 outputs"),
        (LINEAR, {'least_gains': (0.0, 0.0, 0.0)}, 'least_gains must have 1 or 2 gains'),
        (LINEAR, {'most_gains': (-10.0,)}, 'ranges must be finite and rising'),
        (LINEAR, {'mutation': 1.5}, 'mutation must be > 0, <= 1, not 1.5'),
        (LINEAR, {'parameters': ('a11',)}, 'estimates states only'),
        (LINEAR, {'frozen': True}, "unknown setting 'frozen': did you mean 'freeze'?"),
    ],
)
def test_wrong_settings_are_named(model: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        GeneticAdaptiveObserver(model, **arguments)
