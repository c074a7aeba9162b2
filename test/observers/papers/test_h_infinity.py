"""The H-infinity adaptive observer on the suspension; seeds are stated, margins too."""

from typing import Any

import numpy as np
import pytest
from exchanger import played, watched

from obs_ros import Sample
from obs_ros.models.suspension import KT
from obs_ros.observers.papers.adaptive_gains import GAINS, AdaptiveGains
from obs_ros.observers.papers.h_infinity import HInfinityObserver

START = {'kt': 0.5 * KT}


def tracked(seconds: float, sigma: float = 1e-4, seed: int = 1, **settings: Any) -> Any:
    """Times and estimates of kt over trapezoids, the force on the damper rising to 300 N."""
    instants = played('suspension_trap', seconds)
    noise = sigma * np.random.default_rng(seed).standard_normal((len(instants), 3))
    observer = HInfinityObserver('suspension', **{'initial': START, **settings})
    parameters = watched(observer, instants, 'p', noise)
    return np.array([i.t for i in instants]), parameters[:, 0], observer


@pytest.mark.parametrize(
    ('settings', 'most'),
    [({}, 2.5), ({'adaptation': 'gradient', 'gains': 'printed'}, 4.0)],
    ids=['filtered regressor', 'printed gains'],
)
def test_kt_is_found_in_the_first_second_of_the_first_bump(
    settings: dict[str, str], most: float
) -> None:
    """0.1 mm of noise and the disturbance; RMS in % of kt from 13 s on, where it has to stay."""
    t, kt, _ = tracked(16.0, **settings)
    error = kt / KT - 1.0
    assert np.abs(error[t >= 11.0]).max() < 0.1
    assert 100.0 * np.sqrt(np.mean(error[t > 13.0] ** 2)) <= most
    assert np.abs(error[t < 10.0]).max() > 0.3  # on a straight road nothing can be known


def test_with_the_papers_scale_kt_does_not_move() -> None:
    _, kt, _ = tracked(13.0, adaptation='gradient', gains='printed', scale=1.0)
    assert 0.0 < np.abs(kt - 0.5 * KT).max() < 0.1  # N/m


def test_the_papers_start_moves_kt_before_there_is_a_bump() -> None:
    """xhat(0) = 0.1: what looks like convergence comes from the error of the start."""
    wrong = {name: 0.1 for name in ('zs', 'vs', 'zus', 'vus')}
    t, kt, _ = tracked(2.0, initial={**START, **wrong}, sigma=1e-5)
    _, calm, _ = tracked(2.0, sigma=1e-5)
    assert np.abs(kt[t > 1.0] / START['kt'] - 1.0).max() > 0.5
    assert np.abs(calm[t > 1.0] / START['kt'] - 1.0).max() < 0.1


def test_excitation_tells_when_kt_can_be_learnt() -> None:
    instants = played('suspension_trap', 10.3)
    noise = 1e-4 * np.random.default_rng(1).standard_normal((len(instants), 3))
    observer = HInfinityObserver('suspension', initial=START)
    watched(observer, instants[:9000], 'p', noise[:9000])
    straight = dict(observer.figures)
    watched(observer, instants[9000:], 'p', noise[9000:])
    assert observer.figures['excitation'] > 20.0 * straight['excitation']
    assert observer.figures['covariance'] < 0.5 * straight['covariance']


@pytest.mark.parametrize('adaptation', ['filtered', 'gradient'])
@pytest.mark.parametrize('gains', ['designed', 'printed'])
def test_from_any_start_it_stays_finite_and_within_bounds(adaptation: str, gains: str) -> None:
    """30 random starts within the box (seed 5), with gaps and outputs anywhere in it."""
    rng = np.random.default_rng(5)
    for _ in range(30):
        observer = HInfinityObserver(
            'suspension', adaptation=adaptation, gains=gains, seed=0,
            initial={'kt': rng.uniform(0.1, 3.0) * KT, 'vs': rng.uniform(-5, 5),
                     'zs': rng.uniform(-0.5, 0.5), 'vus': rng.uniform(-5, 5)},
        )  # fmt: skip
        for k in range(60):
            y = rng.uniform(-0.5, 0.5, 3)
            y[rng.random(3) < 0.2] = np.nan
            u = np.array([rng.uniform(-0.5, 0.5), 2.0])
            observer.absorb(Sample(k * 1_000_000, y=y, u=u))
            assert (
                np.isfinite(observer.x).all()
                and np.isfinite(observer.innovation[~np.isnan(y)]).all()
            )
            assert 0.1 * KT <= observer.p[0] <= 3.0 * KT
        assert observer.counts['reset_non_finite'] == 0


def test_one_output_of_three_is_enough() -> None:
    instants = played('suspension_trap', 12.0)
    observer = HInfinityObserver('suspension', initial=START)
    missing = np.array([np.nan, 0.0, np.nan])
    watched(observer, instants, 'p', missing * np.ones((len(instants), 1)))
    assert observer.p[0] == pytest.approx(KT, rel=0.1)
    assert np.isnan(observer.innovation).tolist() == [True, False, True]


def test_rare_outputs_are_taken_in_steps_of_the_model() -> None:
    instants = played('suspension_trap', 12.0)
    fine, coarse = (HInfinityObserver('suspension', initial=START) for _ in range(2))
    watched(fine, instants, 'p')
    watched(coarse, instants[::5], 'p')
    assert fine.p[0] == pytest.approx(KT, rel=0.02)
    # The road is held for 5 ms then, where it rises by 1.25 mm.
    assert coarse.p[0] == pytest.approx(KT, rel=0.05)


def test_wrong_settings_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match='leave kt free: HInfinityObserver adapts it'):
        HInfinityObserver('suspension', fixed={'kt': 2e5})
    with pytest.raises(ValueError, match=r"adapts kt of suspension, not \('eta',\)"):
        HInfinityObserver('suspension', parameters=('eta',))
    with pytest.raises(ValueError, match="no H-infinity gains are stored for model 'three_tank'"):
        HInfinityObserver('three_tank')
    wrong = AdaptiveGains('kt', (1.0,), GAINS['suspension'].L, GAINS['suspension'].H)
    monkeypatch.setitem(GAINS, 'suspension', wrong)
    with pytest.raises(ValueError, match='B has 1 entries: 4 needed'):
        HInfinityObserver('suspension')
