"""Plants under poor and rich inputs: their truth, their boxes, their inputs."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.zoo.experiments import EXPERIMENTS, Drawn, Experiment, run
from obs_ros.core.typing import Array


def eighth_order(experiment: Experiment, drawn: Drawn) -> Array:
    """Return outputs (K, r) by DOP853, which begins anew wherever an input moves."""
    model, (t, u) = experiment.model, (drawn.record.t, drawn.record.u)
    moved = np.flatnonzero((np.diff(u, axis=0) != 0.0).any(axis=1)) + 1
    ends = np.unique([0, *moved, t.size - 1])
    x = [drawn.x[0]]
    for first, last in itertools.pairwise(ends):
        found = solve_ivp(
            lambda time, state, held: model.dynamics(time, state, held, drawn.p),
            (t[first], t[last]), x[-1], 'DOP853', t[first + 1 : last + 1],
            args=(u[first],), rtol=1e-11, atol=1e-12,
        )  # fmt: skip
        x += list(found.y.T)
    return np.array([model.output(t[k], x[k], u[k], drawn.p) for k in range(t.size)])


@pytest.mark.parametrize('rich', [False, True])
@pytest.mark.parametrize('name', EXPERIMENTS)
def test_the_truth_is_that_of_an_integrator_of_eighth_order(name: str, rich: bool) -> None:
    experiment = EXPERIMENTS[name]
    quiet = run(experiment._replace(noise=(0.0,) * len(experiment.noise)), 3, rich)
    off = (quiet.record.y - eighth_order(experiment, quiet)) / experiment.noise
    # Where the levels of two tanks cross, flows go through a square root.
    assert np.abs(off).max() < 2e-3
    noisy = run(experiment, 3, rich)
    np.testing.assert_array_equal(noisy.x, quiet.x)
    noise = (noisy.record.y - quiet.record.y).std(axis=0)
    np.testing.assert_allclose(noise, experiment.noise, rtol=0.25)


@pytest.mark.parametrize('name', EXPERIMENTS)
def test_runs_stay_in_their_boxes_and_poor_inputs_move_once_in_a_window(name: str) -> None:
    experiment = EXPERIMENTS[name]
    states, parameters = experiment.model.states, experiment.model.parameters
    for seed in range(8):
        for rich in (False, True):
            drawn = run(experiment, seed, rich, 10)
            for variables, values in ((states, drawn.x), (parameters, drawn.p[None])):
                assert (values >= [v.lower for v in variables]).all()
                assert (values <= [v.upper for v in variables]).all()
            moved = (np.diff(drawn.record.u, axis=0) != 0.0).sum(axis=0)
            assert rich or (moved <= 10).all()
            assert not rich or (moved > 100).all()
        window = drawn.window(experiment.samples, experiment.samples)
        assert window.record.t[0] == drawn.record.t[experiment.samples]
        assert window.x.shape == (experiment.samples, len(states))
