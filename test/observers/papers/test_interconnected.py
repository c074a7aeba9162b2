"""Tests of obs_ros.observers.papers.interconnected against the specification's numbers."""

import numpy as np
import pytest
from exchanger import AT_REST, COLD, FLOWS, coloured, played, rms_percent, settled, watched

from obs_ros.observers.papers.interconnected import InterconnectedObserver


@pytest.mark.slow
def test_case_1_settles_as_fast_as_the_paper_says_and_never_leaves_its_bounds() -> None:
    instants = played('heat_exchanger_case1', 8.0)
    observer = InterconnectedObserver('heat_exchanger', theta=80.0, **COLD)
    flows = watched(observer, instants, 'flows')
    fp, fu = settled(flows, FLOWS, np.array([i.t for i in instants]))
    assert fp <= 0.7 and fu <= 0.55
    assert flows.min() >= 0.0
    assert (flows.max(axis=0) <= 5.0 * FLOWS * (1.0 + 1e-12)).all()
    # g passes zero at 0.04 s.
    assert flows[-1] == pytest.approx(FLOWS, rel=1e-5)
    assert observer.x[:2] == pytest.approx(instants[-1].x[:2], abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('theta', 'least', 'most'), [(2.0, (0.3, 1.0), (0.8, 2.0)), (80.0, (9.0, 35.0), (15.0, 60.0))]
)
def test_noise_in_the_flows(
    theta: float, least: tuple[float, ...], most: tuple[float, ...]
) -> None:
    """0.05 K over 0.1 s, 20 s after 2 s: at theta 80, the paper's, Fu is lost in noise."""
    instants = played('heat_exchanger_case1', 22.0, AT_REST)
    observer = InterconnectedObserver('heat_exchanger', theta=theta)
    flows = watched(observer, instants, 'flows', coloured(len(instants), seed=1))
    rms = rms_percent(flows[2000:], FLOWS)
    assert (np.array(least) <= rms).all() and (rms <= np.array(most)).all()


def test_pulling_the_valves_model_to_the_flow_hides_the_fault() -> None:
    instants = played('heat_exchanger_case1', 10.0, AT_REST, (1.0, 'dP1', 4.0e5))
    observer = InterconnectedObserver('heat_exchanger', l1=100.0)
    watched(observer, instants, 'flows')
    assert abs(observer.figures['residual_Fu']) < 0.05


def test_rare_outputs_are_observed_with_steps_as_short_as_it_takes() -> None:
    """50 ms between outputs are four time constants of theta = 80."""
    instants = played('heat_exchanger_case1', 8.0)[::50]
    observer = InterconnectedObserver('heat_exchanger', theta=80.0, **COLD)
    flows = watched(observer, instants, 'flows')
    assert flows[-1] == pytest.approx(FLOWS, rel=0.01)
