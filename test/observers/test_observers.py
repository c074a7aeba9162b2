"""Tests of every observer of the registry: what it must do with any stream of samples."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from arx import ARX
from plants import NAN, observer_form, rich_input, trajectory

from obs_ros import Estimate, Model, Outcome, Sample, load_model, load_observer
from obs_ros.core.model import inside, names
from obs_ros.core.periods import within
from obs_ros.core.typing import Array
from obs_ros.models import MODELS
from obs_ros.models.three_tank import THREE_TANK
from obs_ros.observers.base import OBSERVERS
from obs_ros.observers.settings import parameter_specs
from obs_ros.samples.range_check import limits

COUNT = 202
IMMEDIATE = [name for name in OBSERVERS if load_observer(name).immediate]


@dataclass(frozen=True)
class Case:
    """A plant with its truth, sampled every `period` s; noise of sd sigma on the outputs."""

    model: Model
    period: float
    x0: tuple[float, ...]
    p: tuple[float, ...]
    sigma: float

    def u(self, t: float) -> tuple[float, ...]:
        if self.model is THREE_TANK:
            return (30.0, 30.0)
        return tuple(inside(v) + rich_input(t) for v in self.model.inputs)

    def stream(self, count: int = COUNT, start: int = 1000) -> list[Sample]:
        """All outputs and all inputs, at every period from `start` periods on."""
        y = truth(self, count)
        y = y + self.sigma * np.random.default_rng(1).standard_normal(y.shape)
        return [
            Sample(round((start + k) * self.period * 1e9), y=y[k], u=self.inputs(k))
            for k in range(count)
        ]

    def inputs(self, k: int) -> Array:
        return np.array(self.u(k * self.period))


@cache
def truth(case: Case, count: int) -> Array:
    """Outputs (count, ...) without noise."""
    fine = max(1, round(case.period / min(case.model.max_step, case.period)))
    t = case.period / fine * np.arange((count - 1) * fine + 1)
    x = trajectory(case.model, t, case.u, case.x0, case.p)[::fine]
    return np.array([case.model.output(0.0, tuple(row), case.u(0.0), case.p) for row in x])


# Enough, and quick without a compiler.
LIGHT: dict[str, dict[str, Any]] = {
    'gase': {'population': 60, 'parents': 20, 'elite': 4, 'generations': 4}
}
TANKS = Case(THREE_TANK, 1.0, (50.0, 40.0, 45.0), (0.6, 0.5, 0.7), 0.01)
FORM = Case(observer_form(), 0.05, (0.0, 0.0, 0.0), (2.1, 2.1, 1.0, 1.0, 0.9, 0.8), 1e-4)


def case_of(name: str) -> Case:
    """The first plant that suits the observer."""
    suits = getattr(load_observer(name), 'suits', lambda model: None)
    estimates = getattr(load_observer(name), 'estimates_parameters', True)
    others = (
        Case(model, min(model.max_step, 1.0), *midst(model), 1e-4)
        for model in map(load_model, MODELS)
    )
    for case in (TANKS, FORM, *others):
        try:
            suits(case.model)
        except ValueError as error:
            assert case.model.name in str(error)
            continue
        if not estimates and any(v.nominal is None for v in case.model.parameters):
            continue  # they would have to be given
        return case
    raise AssertionError(f'no plant suits {name}')


def midst(model: Model) -> tuple[tuple[float, ...], tuple[float, ...]]:
    x0, p = ([inside(v) for v in group] for group in (model.states, model.parameters))
    return tuple(x0), tuple(p)


def make(name: str, *, model: Model | None = None, **settings: Any) -> Any:
    case = case_of(name)
    noise = dict.fromkeys(names(case.model.outputs), case.sigma)
    windows = {'duration': 100.0 * case.period} if name == 'sliding_window' else {'noise': noise}
    windows |= LIGHT.get(name, {})
    return load_observer(name)(model or case.model, **windows, **settings)


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
    assert np.isfinite(list(estimate.figures.values())).all()
    assert estimate.outcome and estimate.message


def check_intervals(estimate: Estimate) -> None:
    """Each has an interval that holds its value; parameters as far as they have deviations."""
    assert list(estimate.interval) == list(estimate.stddev)
    for name, value in {**estimate.state, **estimate.parameters}.items():
        lower, upper = estimate.interval[name]
        assert np.isnan(lower) == np.isnan(upper)
        assert np.isnan(lower) or lower <= value <= upper
    for name in estimate.parameters:
        assert np.isnan(estimate.interval[name][0]) == np.isnan(estimate.stddev[name])


def check_follows(case: Case, estimate: Estimate, start: int = 1000) -> None:
    """The estimate's outputs are the plant's, and its stamp that of the sample."""
    check_finite(estimate)
    at = round(estimate.t1 / case.period - start)
    assert estimate.stamp == round((start + at) * case.period * 1e9)
    x, p = tuple(estimate.state.values()), tuple(estimate.parameters.values())
    y = case.model.output(0.0, x, case.u(at * case.period), p)
    assert np.asarray(y) == pytest.approx(truth(case, at + 1)[at], abs=0.05)


@pytest.mark.parametrize('name', OBSERVERS)
class TestEveryObserver:
    def test_it_follows_the_plant(self, name: str) -> None:
        observer, case = make(name), case_of(name)
        assert observer.model is case.model
        assert observer.prepare() >= 0.0
        found = run(observer, case.stream())
        assert found
        check_follows(case, found[-1])
        assert set(found[-1].stddev) == set(names(case.model.variables))
        for estimate in found:
            check_intervals(estimate)

    def test_before_the_first_sample_nothing_is_due(self, name: str) -> None:
        assert make(name).estimate(0.0) is None

    def test_nan_in_no_nan_out(self, name: str) -> None:
        samples = case_of(name).stream()
        rng = np.random.default_rng(2)
        for k, sample in enumerate(samples):
            y, u = sample.y.copy(), sample.u.copy()
            y[rng.random(y.size) < 0.2] = rng.choice([NAN, np.inf, -np.inf])
            if k % 7 == 3:
                u[rng.integers(u.size)] = NAN
            samples[k] = Sample(sample.stamp, y=y, u=u)
        observer = make(name)
        found = run(observer, samples)
        assert found
        for estimate in found:
            check_finite(estimate)
        assert observer.counts['nan'] + observer.counts['all_nan'] > 30

    def test_nothing_but_nan_gives_no_values(self, name: str) -> None:
        observer = make(name)
        stream = case_of(name).stream()
        nothing = [Sample(s.stamp, y=np.full_like(s.y, NAN), u=s.u) for s in stream]
        for estimate in run(observer, nothing):
            assert not estimate.usable
            check_intervals(estimate)
            assert np.isnan(list(estimate.interval.values())).all()
        assert sum(observer.counts.values()) >= COUNT

    def test_after_a_reset_it_is_as_new(self, name: str) -> None:
        observer, case = make(name, seed=7), case_of(name)
        first = run(observer, case.stream())
        observer.reset()
        assert observer.estimate(0.0) is None
        again = run(observer, case.stream())
        assert [e.parameters for e in again] == [e.parameters for e in first]
        assert [e.state for e in again] == [e.state for e in first]

    def test_two_with_one_seed_agree_to_the_last_bit(self, name: str) -> None:
        one, other = (run(make(name, seed=3), case_of(name).stream()) for _ in range(2))
        assert [(e.state, e.parameters) for e in one] == [(e.state, e.parameters) for e in other]

    @pytest.mark.parametrize('start', [0, 10_000_000])
    def test_a_jump_of_time_starts_it_anew_and_is_told(self, name: str, start: int) -> None:
        observer, case = make(name), case_of(name)
        run(observer, case.stream())
        assert observer.last_break is None
        found = run(observer, case.stream(COUNT + 8, start))
        assert observer.last_break
        assert ('back' if start == 0 else 'ahead') in observer.last_break
        assert observer.counts['reset'] == 1
        assert found[-1].t0 >= start * case.period
        check_follows(case, found[-1], start)

    def test_known_delays_change_nothing_but_the_stamps(self, name: str) -> None:
        """Inputs are stamped ahead, outputs behind; the delays declared put both right."""
        case = case_of(name)
        model = replace(
            case.model,
            inputs=[replace(v, delay=-3.0 * case.period) for v in case.model.inputs],
            outputs=[replace(v, delay=2.0 * case.period) for v in case.model.outputs],
        )
        parts = [Sample(s.stamp, u=s.u) for s in case.stream()]
        parts += [Sample(s.stamp, y=s.y) for s in case.stream()]
        moved = [
            Sample(s.stamp + round((2 if s.u is None else 3) * case.period * 1e9), y=s.y, u=s.u)
            for s in parts
        ]
        expected = run(make(name), sorted(parts, key=lambda s: s.stamp))
        observer = make(name, model=model)
        found = run(observer, sorted(moved, key=lambda s: s.stamp))
        assert len(expected) - 2 <= len(found) <= len(expected)
        for one, other in zip(expected, found, strict=False):
            assert (one.stamp, one.t0, one.t1) == (other.stamp, other.t0, other.t1)
            assert (one.state, one.parameters) == (other.state, other.parameters)
        assert not any(observer.counts[why] for why in ('late', 'reordered', 'duplicate'))

    @pytest.mark.parametrize('values', [('y', 1), ('u', 1), ('y', 0)])
    def test_wrong_numbers_of_values_are_refused_and_it_lives_on(
        self, name: str, values: tuple[str, int]
    ) -> None:
        observer, case = make(name), case_of(name)
        which, more = values
        group = case.model.outputs if which == 'y' else case.model.inputs
        shape = (len(group) + more,) if more else (1, len(group))
        what = 'outputs' if which == 'y' else 'inputs'
        with pytest.raises(ValueError, match=f'{what} of shape'):
            observer.absorb(Sample(0, **{which: np.zeros(shape)}))
        check_finite(run(observer, case.stream())[-1])


@pytest.mark.parametrize('name', IMMEDIATE)
class TestEveryImmediateObserver:
    def test_each_output_gives_one_estimate_and_no_input_does(self, name: str) -> None:
        observer = make(name)
        for sample in case_of(name).stream(20):
            assert not observer.absorb(Sample(sample.stamp, u=sample.u))
            assert observer.absorb(Sample(sample.stamp, y=sample.y))
            assert observer.estimate().stamp == sample.stamp
            assert observer.estimate() is None

    def test_a_delay_to_be_estimated_is_refused_with_the_way_out(self, name: str) -> None:
        case = case_of(name)
        outputs = [replace(v, delay=(0.0, case.period)) for v in case.model.outputs]
        with pytest.raises(ValueError, match='as one number, or take the observer sliding_window'):
            make(name, model=replace(case.model, outputs=outputs))

    def test_what_is_given_is_sure(self, name: str) -> None:
        kind, case = load_observer(name), case_of(name)
        given = names(case.model.parameters)
        if kind.estimates_parameters:
            given = given[:1]
        fixed = dict(zip(given, case.p, strict=False))
        try:
            observer = make(name, fixed=fixed)
        except ValueError as error:
            pytest.skip(str(error))
        estimate = run(observer, case.stream(20))[-1]
        for each, value in fixed.items():
            assert (estimate.parameters[each], estimate.stddev[each]) == (value, 0.0)
            assert estimate.interval[each] == (value, value)

    def test_outputs_that_are_not_newer_change_nothing_and_are_counted(self, name: str) -> None:
        samples = case_of(name).stream(40)
        plain = run(make(name), samples)
        observer = make(name)
        disturbed = []
        for k, sample in enumerate(samples):
            disturbed += run(observer, [sample])
            wrong = Sample(samples[max(0, k - k % 3)].stamp, y=sample.y + 9.0)
            disturbed += run(observer, [wrong])
        assert [e.state for e in disturbed] == [e.state for e in plain]
        assert observer.counts['duplicate'] == 14 and observer.counts['late'] == 26

    def test_an_absurd_output_is_survived(self, name: str) -> None:
        observer, case = make(name), case_of(name)
        samples = case.stream()
        most = limits(observer.model, observer.model.outputs)
        for k in (20, 21):
            absurd = np.array([0.99 * high for _, high in most])
            samples[k] = Sample(samples[k].stamp, y=absurd, u=samples[k].u)
        found = run(observer, samples)
        assert len(found) == COUNT
        for estimate in found:
            check_intervals(estimate)
            assert estimate.usable or estimate.outcome is Outcome.DIVERGED
        diverged = sum(estimate.outcome is Outcome.DIVERGED for estimate in found)
        assert observer.counts['reset_non_finite'] == diverged
        assert found[-1].usable

    def test_with_and_without_compiler_it_says_the_same(self, name: str) -> None:
        pytest.importorskip('numba')
        both = [run(make(name, backend=b), case_of(name).stream()) for b in ('numba', 'numpy')]
        compiled, plain = ([[*e.state.values(), *e.parameters.values()] for e in es] for es in both)
        np.testing.assert_allclose(compiled, plain, rtol=1e-9, atol=1e-9)

    def test_its_settings_describe_and_check_themselves(self, name: str) -> None:
        kind = load_observer(name).Settings
        for spec in parameter_specs(kind):
            assert spec.description
            assert spec.coerce(spec.default) == spec.default
        with pytest.raises(ValueError, match="unknown setting 'longest_gip': did you mean"):
            make(name, longest_gip=1.0)
        with pytest.raises(ValueError, match='longest_gap must be 0 to 10000 s, not -1'):
            make(name, longest_gap=-1.0)

    def test_prepare_leaves_no_trace(self, name: str) -> None:
        prepared, case = make(name), case_of(name)
        prepared.prepare()
        assert prepared.estimate() is None and not any(prepared.counts.values())
        states = [[e.state for e in run(o, case.stream(30))] for o in (prepared, make(name))]
        assert states[0] == states[1]


@pytest.mark.parametrize('name', IMMEDIATE)
def test_outputs_that_wrap_are_followed_like_those_that_do_not(name: str) -> None:
    """Periods are powers of two here: then whole periods away numbers keep their bits."""
    case = case_of(name)
    samples = case.stream(120)
    y = np.array([sample.y for sample in samples])
    period = 2.0 ** np.ceil(np.log2(np.abs(y).max(axis=0)))
    outputs = [replace(v, period=float(p)) for v, p in zip(case.model.outputs, period, strict=True)]
    wraps = replace(case.model, outputs=outputs)
    assert (within(y, period) != y).any()
    values = (*case.x0, *case.p)
    initial = dict(zip(names(case.model.variables), values, strict=True))
    arguments = {
        'noise': dict.fromkeys(names(case.model.outputs), case.sigma), 'backend': 'numpy',
        'innovation_gate': 0.0, **LIGHT.get(name, {}),
    }  # fmt: skip
    found = []
    for model, measured in ((case.model, y), (wraps, within(y, period))):
        observer = load_observer(name)
        given = (
            initial
            if getattr(observer, 'estimates_parameters', True)
            else {v.name: initial[v.name] for v in model.states}
        )
        estimates = run(
            observer(model, initial=given, **arguments),
            [Sample(s.stamp, y=row, u=s.u) for s, row in zip(samples, measured, strict=True)],
        )
        found.append(estimates)
    for plain, wrapped in zip(*found, strict=True):
        assert wrapped.state == plain.state and wrapped.parameters == plain.parameters
        for output, p in zip(outputs, period, strict=True):
            assert not abs(wrapped.innovation[output.name]) > 0.5 * p


@pytest.mark.parametrize('name', OBSERVERS)
def test_discrete_models_are_taken_or_refused_with_the_observers_that_do(name: str) -> None:
    kind = load_observer(name)
    if name in ('sliding_window', 'ekf', 'ukf'):
        windows = {'duration': 5.0} if name == 'sliding_window' else {}
        kind(ARX, backend='numpy', **windows)
        return
    with pytest.raises(ValueError, match=r"take the observer sliding_window, ekf or ukf: .*'arx'"):
        kind(ARX)
