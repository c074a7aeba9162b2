import keyword
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from obs_ros.cli.package_signals import (
    Signal,
    Signals,
    check_name,
    named,
    of_header,
    of_names,
    proposed_name,
)

BATTERY = ['t', 'cur [A]', 'volt']


@given(st.one_of(st.text(max_size=50), st.sampled_from(keyword.kwlist), st.from_regex(r'\w+')))
def test_a_name_is_refused_or_is_a_variable_of_python(text):
    try:
        check_name(text)
    except ValueError as error:
        assert str(error).startswith('give a name') and str(error).isprintable()
        check_name(proposed_name(text))  # what is advised is accepted
    else:
        assert text.isidentifier() and text.isascii() and not keyword.iskeyword(text)
        assert 0 < len(text) <= 40


@settings(max_examples=60)
@given(
    st.lists(st.from_regex(r'[a-c]{1,2}(_[ab])?', fullmatch=True), max_size=4), st.integers(0, 3)
)
def test_every_variable_has_a_name_of_its_own_or_the_signals_are_refused(names, inputs):
    signals = [Signal(name) for name in names]
    try:
        found = Signals(tuple(signals[:inputs]), tuple(signals[inputs:]))
    except ValueError as error:
        assert re.match('name|give', str(error))
    else:
        assert len({*names, *found.parameters}) == len(names) + len(found.parameters)
        assert len(found.parameters) == len(found.outputs) * (len(found.inputs) + 2)


def test_units_come_from_the_command_line_or_the_brackets_of_the_header():
    assert named('--input', 'cur=A') == Signal('cur', 'A')
    assert named('--input', 'cur') == Signal('cur', '1')
    found = of_header(BATTERY, {}, [named('--input', 'cur')], [])
    assert found.inputs == (Signal('cur', 'A', 'cur [A]'),)
    assert found.outputs == (Signal('volt', '1', 'volt'),)
    assert found.columns == {'cur': 'cur [A]'}
    (cell,) = of_header(BATTERY, {}, [Signal('cur')], [named('--output', 'volt=V')]).outputs
    assert cell.unit == 'V'
    (current,) = of_header(['cur (mA)', 'y'], {}, [named('--input', 'cur=A')], []).inputs
    assert (current.unit, current.column) == ('A', 'cur (mA)')


def test_the_kind_that_is_not_named_has_all_columns_that_are_left():
    header = ['time_ms', 'a', 'b', 'c']
    assert [s.name for s in of_header(header, {}, [Signal('b')], []).outputs] == ['a', 'c']
    assert [s.name for s in of_header(header, {}, [], [Signal('b')]).inputs] == ['a', 'c']
    both = of_header(header, {}, [Signal('a')], [Signal('b')])
    assert [s.name for s in (*both.inputs, *both.outputs)] == ['a', 'b']
    alone = of_header(['t', 'y'], {}, [], [Signal('y')])
    assert (alone.inputs, [s.name for s in alone.outputs]) == ((), ['y'])


def test_a_column_gets_another_name():
    header = ['clock', 'Motor Speed', 'class']
    columns = {'t': 'clock', 'kind': 'class', 'speed': 'Motor Speed'}
    found = of_header(header, columns, [Signal('kind')], [])
    assert found.columns == columns
    assert [s.name for s in found.outputs] == ['speed']


@pytest.mark.parametrize(
    ('header', 'columns', 'inputs', 'outputs', 'words'),
    [
        ('t a b', {}, '', '', 'say which columns are inputs.*there are a, b'),
        ('t', {}, '', '', 'none but the time'),
        ('t a a', {}, 'a', '', "more than one is called 'a'"),
        ('t volt', {}, '', 'volts', "no column 'volts': did you mean 'volt'"),
        ('t a', {'x': 'c'}, 'a', '', "--column: there is no column 'c'"),
        ('t a', {}, 'a', '', 'at least one output'),
        ('t a b', {}, 'a', 'a', "'a' is there more than once"),
        ('t Motor-Speed b', {}, 'b', '', "--column motor_speed='Motor-Speed'"),
        ('t class b', {}, 'b', '', "'class' is a word of Python.*--column class_='class'"),
        ('t 1st b', {}, 'b', '', "--column _1st='1st'"),
        ('t µ b', {}, 'b', '', "--column signal='µ'"),
        ('t u b', {}, 'b', '', '--output y --column y=u'),
        ('t lag_b b', {}, 'lag_b', '', "more than one variable 'lag_b'"),
        ('t a[123456789012345678901] b', {}, 'b', '', 'give a a unit of 1 to 20'),
        ('t a[\x1b] b', {}, 'b', '', 'printable'),
        (' '.join(['t', *(f'a{i}' for i in range(62))]), {}, '', 'a0', 'matter: 61 inputs'),
    ],
)  # fmt: skip
def test_wrong_columns_are_refused_with_advice(header, columns, inputs, outputs, words):
    asked = ([Signal(name) for name in names.split()] for names in (inputs, outputs))
    with pytest.raises(ValueError, match=words):
        of_header(header.split(' '), columns, *asked)


@pytest.mark.parametrize('text', ['', '=A', 'cur='])
def test_a_name_and_its_unit_are_both_there(text):
    with pytest.raises(ValueError, match='--input must be NAME or NAME=UNIT'):
        named('--input', text)


def test_a_plant_without_an_output_is_none():
    with pytest.raises(ValueError, match='at least one output'):
        of_names([Signal('a')], [])
