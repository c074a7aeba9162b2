"""Tests of every observer of the registry: what it must do with any stream of samples."""

from typing import Any

import numpy as np
import pytest
from plants import NAN, tank_outputs

from obs_ros import Estimate, Sample, load_observer
from obs_ros.observers import OBSERVERS

S = 10**9
FEED = np.array([30.0, 30.0])


def make(name: str) -> Any:
    settings = {'duration': 100.0} if name == 'sliding_window' else {}
    return load_observer(name)('three_tank', **settings)


def stream(seconds: int = 202, start: int = 1000) -> list[Sample]:
    """Both outputs and both inputs, once a second."""
    y = tank_outputs(np.arange(float(seconds)), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
    y += 0.01 * np.random.default_rng(1).standard_normal(y.shape)
    return [Sample((start + k) * S, y=y[k], u=FEED) for k in range(seconds)]


def run(observer: Any, samples: list[Sample]) -> list[Estimate]:
    """Absorb all, and ask for an estimate whenever one is due."""
    found = []
    for sample in samples:
        if observer.absorb(sample):
            estimate = observer.estimate()
            assert estimate is not None
            found.append(estimate)
    return found


def check_finite(estimate: Estimate) -> None:
    assert estimate.usable
    assert np.isfinite(estimate.residual_rms)
    assert estimate.outcome and estimate.message


@pytest.mark.parametrize('name', OBSERVERS)
class TestEveryObserver:
    def test_it_follows_the_plant(self, name: str) -> None:
        observer = make(name)
        assert observer.model.name == 'three_tank'
        assert observer.prepare() >= 0.0
        found = run(observer, stream())
        assert found
        check_finite(found[-1])
        truth = tank_outputs(np.arange(202.0), (50.0, 40.0, 45.0), (0.6, 0.5, 0.7))
        at = round(found[-1].t1 - 1000.0)
        assert found[-1].state['h1'] == pytest.approx(truth[at, 0], abs=0.05)
        assert found[-1].stamp == (1000 + at) * S

    def test_before_the_first_sample_nothing_is_due(self, name: str) -> None:
        assert make(name).estimate(0.0) is None

    def test_nan_in_no_nan_out(self, name: str) -> None:
        samples = stream()
        rng = np.random.default_rng(2)
        for k, sample in enumerate(samples):
            y, u = sample.y.copy(), sample.u.copy()
            y[rng.random(2) < 0.2] = rng.choice([NAN, np.inf, -np.inf])
            if k % 7 == 3:
                u[rng.integers(2)] = NAN
            samples[k] = Sample(sample.stamp, y=y, u=u)
        found = run(make(name), samples)
        assert found
        for estimate in found:
            check_finite(estimate)

    def test_nothing_but_nan_gives_no_values(self, name: str) -> None:
        observer = make(name)
        nothing = [Sample(s.stamp, y=np.full(2, NAN), u=s.u) for s in stream()]
        for estimate in run(observer, nothing):
            assert not estimate.usable
        assert sum(observer.counts.values()) >= 202

    def test_after_a_reset_it_is_as_new(self, name: str) -> None:
        observer = make(name)
        first = run(observer, stream())
        observer.reset()
        assert observer.estimate(0.0) is None
        again = run(observer, stream())
        assert [e.parameters for e in again] == [e.parameters for e in first]

    @pytest.mark.parametrize('start', [0, 100_000])
    def test_a_jump_of_time_starts_it_anew_and_is_told(self, name: str, start: int) -> None:
        observer = make(name)
        run(observer, stream())
        assert observer.last_break is None
        found = run(observer, stream(210, start))
        assert observer.last_break
        assert ('back' if start == 0 else 'ahead') in observer.last_break
        check_finite(found[-1])
        assert found[-1].t0 >= start
        assert found[-1].parameters['p2'] == pytest.approx(0.5, abs=0.05)

    @pytest.mark.parametrize(
        ('sample', 'message'),
        [
            (Sample(0, y=np.zeros(3)), 'outputs of shape'),
            (Sample(0, u=np.zeros(1)), 'inputs of shape'),
            (Sample(0, y=np.zeros((1, 2))), 'outputs of shape'),
        ],
    )
    def test_wrong_numbers_of_values_are_refused_and_it_lives_on(
        self, name: str, sample: Sample, message: str
    ) -> None:
        observer = make(name)
        with pytest.raises(ValueError, match=message):
            observer.absorb(sample)
        check_finite(run(observer, stream())[-1])


def test_observers_are_found_by_path_and_others_refused() -> None:
    assert load_observer(OBSERVERS['sliding_window']) is load_observer('sliding_window')
    with pytest.raises(ValueError, match="unknown observer 'slidin_window': did you mean"):
        load_observer('slidin_window')
    with pytest.raises(ValueError, match=r"observer 'math:pi' is 3\.14.*, not an observer class"):
        load_observer('math:pi')
