"""Tests of what observers that step from output to output have in common."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, OSCILLATOR, exact, with_interpolation

from obs_ros import Outcome, Sample, Variable
from obs_ros.integration.path import LANES
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.kalman_filters.ekf import ExtendedKalmanObserver
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.recursive import RecursiveObserver

P = {'stiffness': 0.8, 'push': 0.7}
MS = 1_000_000


class OpenLoop(RecursiveObserver):
    """Lets the model run, and never looks at the outputs."""

    def _start(self, now: Instant) -> None:
        self.steps: list[tuple[Instant, Instant]] = []
        self.lanes = np.repeat(self.x[:, None], LANES, axis=1)
        self.parameters = np.repeat(self.p[:, None], LANES, axis=1)

    def _step(self, before: Instant, now: Instant, path: Any) -> None:
        self.stepper.propagate(path, self.lanes, self.parameters)
        self.x[:] = self.lanes[:, 0]
        self.innovation[0] = now.y[0] - self.x[0]
        self.steps.append((before, now))


def observer(model: Any = OSCILLATOR, **arguments: Any) -> OpenLoop:
    initial = {'position': 1.0, 'velocity': -0.5, **P} if model.name == 'oscillator' else None
    return OpenLoop(model, **{'initial': initial, **arguments})


def output(ms: int, y: float = 0.0) -> Sample:
    return Sample(ms * MS, y=np.array([y, 0.0]))


def force(ms: int, u: float) -> Sample:
    return Sample(ms * MS, u=np.array([u]))


@pytest.mark.parametrize('kind', ['hold', 'linear', 'mean'])
def test_the_model_is_carried_with_the_inputs_at_their_own_stamps(backend: str, kind: str) -> None:
    """Inputs between outputs, and one ahead of the last output; against scipy."""
    model = with_interpolation(replace(OSCILLATOR, max_step=0.01), kind)
    found = observer(model, backend=backend)
    stamps, levels = (0, 130, 250, 310, 600), (0.3, -1.0, 2.0, 0.5, -0.7)
    for stamp, level in zip(stamps, levels):
        found.absorb(force(stamp, level))
    for stamp in (0, 200, 500):
        assert found.absorb(output(stamp))
    knots = np.array(stamps) / 1e3
    nodes = np.array([0.0, 0.13, 0.25, 0.31, 0.5])

    def u(k: int, s: float) -> tuple[float]:
        here, after = levels[k], levels[min(k + 1, 4)]
        if kind == 'hold':
            return (here,)
        if kind == 'mean':
            return (0.5 * (here + after),)
        return (here + (after - here) * s / (knots[min(k + 1, 4)] - knots[k] or 1.0),)

    states, _ = exact(model, nodes, u, (1.0, -0.5), tuple(P.values()))
    np.testing.assert_allclose(found.x, states[-1], atol=1e-7)


def test_after_the_last_input_known_it_holds() -> None:
    model = with_interpolation(replace(OSCILLATOR, max_step=0.01), 'linear')
    found = observer(model)
    for sample in (force(0, 0.3), output(0), force(100, 1.3), output(300)):
        found.absorb(sample)
    nodes = np.array([0.0, 0.1, 0.3])
    states, _ = exact(
        model, nodes, lambda k, s: (0.3 + 10.0 * s if k == 0 else 1.3,), (1.0, -0.5), (0.8, 0.7)
    )
    np.testing.assert_allclose(found.x, states[-1], atol=1e-7)


def test_hooks_see_outputs_and_inputs_before_and_now() -> None:
    found = observer()
    for sample in (force(0, 0.3), output(0, 7.0), force(40, 0.5), output(50, 8.0)):
        found.absorb(sample)
    ((before, now),) = found.steps
    assert (before.stamp, before.t, before.y[0], before.u[0]) == (0, 0.0, 7.0, 0.3)
    assert (now.stamp, now.t, now.y[0], now.u[0]) == (50 * MS, 0.05, 8.0, 0.5)


def test_a_late_input_is_in_force_from_the_newest_output_on_and_counted() -> None:
    late, punctual = observer(), observer()
    for sample in (force(0, 0.3), output(0), output(100), force(40, 0.9), output(200)):
        late.absorb(sample)
    for sample in (force(0, 0.3), output(0), output(100), force(100, 0.9), output(200)):
        punctual.absorb(sample)
    assert late.x.tolist() == punctual.x.tolist()
    assert (late.counts['late'], punctual.counts['late']) == (1, 0)


def test_outputs_before_every_input_is_known_are_counted_as_early() -> None:
    found = OpenLoop(THREE_TANK)
    levels = np.array([50.0, 40.0])
    assert not found.absorb(Sample(0, y=levels))
    found.absorb(Sample(1 * MS, u=np.array([30.0, np.nan])))
    assert not found.absorb(Sample(2 * MS, y=levels))
    found.absorb(Sample(3 * MS, u=np.array([np.nan, 20.0])))
    assert found.absorb(Sample(3 * MS, y=levels))
    assert found.counts['early'] == 2 and found.counts['nan'] == 2
    assert found._before is not None and found._before.u.tolist() == [30.0, 20.0]


def test_values_that_are_not_finite_are_withheld_and_it_starts_again() -> None:
    found = OpenLoop(BLOW_UP, initial={'x': 4.0})  # infinite at 0.25 s
    estimates = []
    for k in range(10):
        found.absorb(Sample(k * 100 * MS, y=np.array([4.0])))
        estimates.append(found.estimate())
    outcomes = [estimate.outcome for estimate in estimates]
    first = outcomes.index(Outcome.DIVERGED)
    assert 2 <= first <= 4
    assert np.isnan(estimates[first].state['x']) and not estimates[first].usable
    assert 'because x was not finite' in estimates[first].message
    again = estimates[first + 1]
    assert again.state['x'] == pytest.approx(4.0 / (1.0 - 4.0 * 0.1), rel=1e-6)
    assert again.usable and f'started again at {0.1 * first:g} s' in again.message
    assert found.counts['reset_non_finite'] == outcomes.count(Outcome.DIVERGED)


def test_estimates_that_nobody_takes_are_skipped() -> None:
    found = observer()
    found.absorb(force(0, 0.0))
    for ms in (0, 10, 20):
        found.absorb(output(ms))
    estimate = found.estimate()
    assert estimate is not None and estimate.stamp == 20 * MS
    assert found.counts['skipped'] == 2
    assert estimate.t0 == estimate.t1 == 0.02
    assert estimate.residual_rms == pytest.approx(abs(found.x[0]))


def test_it_starts_from_what_is_given_else_nominal_else_the_middle() -> None:
    found = OpenLoop(THREE_TANK, fixed={'p1': 0.4, 'h3': 20.0}, bounds={'h1': (0.0, 50.0)},
                     initial={'p2': 0.3})  # fmt: skip
    assert found.initial.tolist() == [25.0, 50.0, 20.0, 0.4, 0.3, 1.0]
    nominal = replace(THREE_TANK, parameters=[Variable(n, '1', 0.0, 1.0, 0.8) for n in 'abc'])
    assert OpenLoop(nominal, bounds={'a': (0.0, 0.5)}).initial[3:].tolist() == [0.5, 0.8, 0.8]


@pytest.mark.parametrize(
    ('arguments', 'reason'),
    [
        ({'initial': {'h9': 1.0}}, "no state or parameter 'h9': did you mean"),
        ({'initial': {'h1': np.nan}}, 'h1 starts from nan'),
        ({'initial': {'p1': 0.5}, 'fixed': {'p1': 0.5}}, 'p1 cannot have an initial value'),
        ({'noise': {'h9': 1.0}}, "noise of unknown output 'h9'"),
        ({'noise': {'h1': 0.0}}, 'noise of h1: standard deviation 0.0 is not positive'),
        ({'noise': 0.1}, 'noise must give a standard deviation by output'),
        ({'seed': -1}, 'seed must be an integer >= 0, not -1'),
        ({'backend': 'fortran'}, "backend 'fortran'"),
        ({'longest_gap': 'long'}, "longest_gap must be a number, not 'long'"),
        ({'lungest_gap': 1.0}, "unknown setting 'lungest_gap': did you mean 'longest_gap'?"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError) as caught:
        OpenLoop(THREE_TANK, **arguments)
    assert reason in str(caught.value)


def test_observers_of_states_take_no_parameters_to_estimate() -> None:
    class StatesOnly(OpenLoop):
        estimates_parameters = False

    assert StatesOnly(THREE_TANK).unknowns.names == ('h1', 'h2', 'h3')
    with pytest.raises(ValueError, match='StatesOnly estimates states only, no parameters'):
        StatesOnly(THREE_TANK, parameters=['p1'])
    with pytest.raises(ValueError, match='stiffness is not estimated and has no nominal value'):
        StatesOnly(OSCILLATOR)


def test_a_time_of_windows_is_refused_where_there_are_none() -> None:
    model = replace(THREE_TANK, time='window')
    with pytest.raises(ValueError, match='use the observer sliding_window'):
        ExtendedKalmanObserver(model)
