"""The first guess, as text that Python reads: a model that follows its equation."""

import keyword
from string import Template

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import OSCILLATOR

from obs_ros.cli.first_guess import Guess
from obs_ros.cli.package_files import package_files
from obs_ros.cli.package_signals import Signal, Signals
from obs_ros.cli.recorded_ranges import Range, Ranges
from obs_ros.core.model import Model, names
from obs_ros.interface.parameters import observer_parameters

NAMES = st.one_of(
    st.sampled_from(['t', 'x', 'p', 'y', 'output', 'dynamics', 'Model', 'Variable', 'PLANT', '_',
                     'print', 'np', 'match', 'self']),
    st.from_regex(r'[A-Za-z_][A-Za-z0-9_]{0,39}', fullmatch=True).filter(
        lambda name: not keyword.iskeyword(name)),
)  # fmt: skip
UNITS = st.one_of(
    st.sampled_from(['1', 'V', "'", '"', '\\', '$x', '{a}', '%']),
    st.text(min_size=1, max_size=20).filter(lambda u: u.isprintable() and u.strip() == u),
)


def model_of(guess: Guess) -> Model:
    """Return the model that the written file defines."""
    scope: dict[str, object] = {}
    exec(package_files('some_plant', guess, None)['some_plant/plant.py'], scope)
    model = scope['PLANT']
    assert isinstance(model, Model)
    return model


def guess_of(inputs, outputs, extents=()):
    """Return the guess for named signals; `extents` are (low, high), repeated as needed."""
    extents = [Range(low, high, 0.5 * (low + high)) for low, high in extents or [(-10.0, 10.0)]]
    count = len(inputs) + len(outputs)
    ranges = (extents * count)[:count]
    return Guess(
        Signals(tuple(inputs), tuple(outputs)),
        Ranges(tuple(ranges[: len(inputs)]), tuple(ranges[len(inputs) :]), 0.1, 100.0),
    )


@pytest.mark.parametrize('duration', [0.002, 0.005, 0.03, 1.0, 1e5, 1e8])
def test_the_window_is_one_that_the_node_takes_and_that_fits(duration):
    (spec,) = (
        s for s in observer_parameters(OSCILLATOR, 'sliding_window') if s.name == 'window.duration'
    )
    extents = (Range(0.0, 1.0, 0.5),)
    for samples in (20, 1000, 100_000):
        ranges = Ranges((), extents, duration / samples, duration)
        window = Guess(Signals((), (Signal('y'),)), ranges).window
        assert spec.coerce(window) == window < duration


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(NAMES, UNITS), min_size=1, max_size=4, unique_by=lambda pair: pair[0]),
    st.integers(0, 3),
    st.tuples(st.floats(-1e6, 1e6), st.floats(0.0, 1e6)),
)
def test_whatever_the_names_the_model_has_them_and_its_rates_are_those_of_lags(pairs, m, extent):
    signals = [Signal(name, unit) for name, unit in pairs]
    m = min(m, len(signals) - 1)
    guess = guess_of(signals[:m], signals[m:], [(extent[0], extent[0] + extent[1])])
    model = model_of(guess)
    assert names(model.inputs) == tuple(s.name for s in signals[:m])
    assert names(model.outputs) == names(model.states) == tuple(s.name for s in signals[m:])
    units = [v.unit for v in (*model.inputs, *model.outputs)]
    assert units == [s.unit for s in signals]
    u = [v.nominal for v in model.inputs]
    x, lags = np.arange(1.0, len(model.states) + 1), [3.0] * len(model.states)
    p = []
    for k, _ in enumerate(model.states):
        p += [10.0 * (k + 1), *([2.0] * m), lags[k]]
    rates = model.dynamics(0.0, tuple(x), tuple(v + 1.0 for v in u), tuple(p))
    expected = (10.0 * x + 2.0 * m - x) / 3.0
    assert np.allclose(rates, expected, rtol=1e-6, atol=1e-6 * max(1.0, *map(abs, u), 0.0))
    assert model.output(0.0, tuple(x), tuple(u), tuple(p)) == tuple(x)


@pytest.mark.parametrize('low', [-1e6, -1e-9, 0.0, 5e-324, 1e-300, 1.0, 123.456, 1e6])
@pytest.mark.parametrize('moved', [0.0, 5e-324, 1e-310, 2e-16, 1e-12, 1e-9, 1e-7, 1.0])
def test_a_signal_that_hardly_moves_has_bounds_as_well(low, moved):
    model = model_of(guess_of([Signal('u', '1')], [Signal('y', '1')], [(low, low + moved)]))
    for variable in (*model.states, *model.parameters):
        assert variable.lower < variable.nominal < variable.upper


@pytest.mark.parametrize(
    'extent', [(0.0, 1.0), (2.4, 3.6), (1000.01, 1000.05), (-5e-7, 5e-7), (7.0, 7.0)]
)
def test_bounds_hold_what_was_recorded_and_the_rest_of_it(extent):
    model = model_of(guess_of([Signal('a')], [Signal('b')], [extent]))
    (state,), (rest, gain, lag) = model.states, model.parameters
    span = extent[1] - extent[0] or 7.0
    assert state.lower <= extent[0] - 0.49 * span and state.upper >= extent[1] + 0.49 * span
    assert state.upper - state.lower < 2.5 * span
    assert extent[0] <= state.nominal <= extent[1] + 0.01 * span
    assert rest.lower < state.lower and rest.upper > state.upper
    assert gain.upper == -gain.lower == pytest.approx(5.0, rel=0.2)
    assert lag.lower < 0.1 <= lag.nominal < guess_of([], [Signal('b')]).window < lag.upper


def test_windows_are_a_tenth_of_the_recording_and_have_samples_enough():
    def window(period, duration):
        extent = Range(0.0, 1.0, 0.5)
        signals = Signals((), (Signal('a'),))
        return Guess(signals, Ranges((), (extent,), period, duration)).window

    assert window(0.2, 3000.0) == 300.0
    assert window(1.0, 200.0) == 50.0
    assert window(1.0, 20.0) == 10.0


def test_long_names_are_written_on_lines_of_their_own():
    many = [Signal(f'an_input_with_a_long_name_{k}') for k in range(6)]
    text = package_files('some_plant', guess_of(many, [Signal('out')]), None)['some_plant/plant.py']
    inside = text.split('PLANT = Model')[0]
    assert max(map(len, inside.splitlines())) <= 100
    assert Template.delimiter not in text
