"""A parameter's row checks values, and describes itself."""

import math

import pytest

from obs_ros.core.parameter_spec import (
    ParameterSpec,
    check_names,
    ignored,
    markdown_table,
    plain,
)  # fmt: skip

GAIN = ParameterSpec('gain', 1.0, 'loop gain', 'V/cm', lower=0.0, upper=5.0)
WORD = ParameterSpec('word', '', 'what to do', choices=('', 'stay', 'leave'))
LIMITS = ParameterSpec('limits', (0.0, 1.0), 'lower and upper', length=2)
DELAY = ParameterSpec('delay', 0.0, 'how late', 's', lower=-9.0, upper=9.0, or_pair=True)
LABEL = ParameterSpec('label', 'x', 'a label', read_only=True)


def test_integers_pass_where_floats_are_meant():
    assert GAIN.coerce(2) == 2.0 and isinstance(GAIN.coerce(2), float)
    assert LIMITS.coerce([0, 1]) == (0.0, 1.0)


def test_a_pair_passes_in_place_of_a_number_where_the_row_says_so():
    assert DELAY.coerce(1) == 1.0 and DELAY.coerce([0, 1]) == (0.0, 1.0)
    assert ParameterSpec('delay', (0.0, 1.0), 'how late', or_pair=True).coerce(2.0) == 2.0
    with pytest.raises(ValueError, match=r'^gain must be a number, not \[0.0, 1.0\]$'):
        GAIN.coerce([0.0, 1.0])


def test_words_that_yaml_reads_as_true_or_false_are_words():
    switch = ParameterSpec('switch', 'auto', 'when to switch', choices=('off', 'auto', 'on'))
    assert [switch.coerce(value) for value in (False, True, 'off')] == ['off', 'on', 'off']
    with pytest.raises(ValueError, match=r'^word must be text, not False$'):
        WORD.coerce(False)


@pytest.mark.parametrize(
    ('spec', 'value', 'text'),
    [
        (GAIN, 6.0, 'gain must be 0 to 5 V/cm, not 6.0'),
        (GAIN, math.nan, 'gain must be 0 to 5 V/cm, not nan'),
        (GAIN, True, 'gain must be a number, not True'),
        (GAIN, None, 'gain must be a number, not None'),
        (WORD, 'leaf', "unknown word 'leaf': did you mean 'leave'?"),
        (LIMITS, [1.0], 'limits must have 2 entries, not 1'),
        (DELAY, [0.0, 10.0], 'delay must be -9 to 9 s, not 10.0'),
        (DELAY, [0.0], 'delay must have 2 entries, not 1'),
        (DELAY, 'soon', "delay must be a number, not 'soon'"),
        (LIMITS, '[0, 1]', "limits must be an array like [0.0, 1.0], not '[0, 1]'"),
    ],
)
def test_wrong_values_are_refused_with_the_reason(spec, value, text):
    with pytest.raises(ValueError) as caught:
        spec.coerce(value)
    assert str(caught.value) == text


@pytest.mark.parametrize('value', [(1.0, 5.1), (-0.1, 1.0), (math.nan, 1.0), (0.0,) * 1001])
def test_entries_of_arrays_are_bounded_too(value):
    with pytest.raises(ValueError, match=r'^array must '):
        ParameterSpec('array', (1.0, 2.0), 'numbers', lower=0.0, upper=5.0).coerce(value)


@pytest.mark.parametrize('value', [2**63, -(2**63), 10**5000], ids=['large', 'small', 'huge'])
def test_integers_are_those_of_ros(value):
    with pytest.raises(ValueError, match=r'^count must be an integer of 64 bits$'):
        ParameterSpec('count', 1, 'a count').coerce(value)


@pytest.mark.parametrize(
    ('row', 'words'),
    [
        (GAIN, '0 to 5'),
        (WORD, "'' | stay | leave"),
        (LABEL, ''),
        (ParameterSpec('x', 1.0, 'x', lower=0.0), '>= 0'),
        (ParameterSpec('x', 1.0, 'x', positive=True), '> 0'),
        (ParameterSpec('x', 1.0, 'x', positive=True, upper=1e6), '> 0, <= 1e6'),
        (ParameterSpec('x', 1, 'x', lower=0, upper=1_000_000), '0 to 1000000'),
    ],
)
def test_the_range_is_told_in_words(row, words):
    assert row.range == words


def test_a_nan_passes_where_it_means_something():
    row = ParameterSpec('x', math.nan, 'x', lower=0.0, upper=1.0, nan=True)
    assert math.isnan(row.coerce(math.nan)) and row.coerce(0.5) == 0.5
    with pytest.raises(ValueError, match=r'^x must be 0 to 1, not 2'):
        row.coerce(2.0)


def test_descriptions_have_unit_range_and_when():
    assert GAIN.describe() == 'loop gain (in V/cm; 0 to 5)'
    assert LABEL.describe() == 'a label (at start only)'
    assert markdown_table([WORD, LIMITS]).splitlines()[2:] == [
        "| `word` |  | what to do ('' \\| stay \\| leave) |",
        '| `limits` | `[0.0, 1.0]` | lower and upper |',
    ]


def test_names_that_mean_nothing_are_named_with_close_ones_and_old_ones_refused():
    words = ignored(['gian', 'xyz'], ['gain', 'word'])
    assert words == "ignored, as there are no such parameters: 'gian' (did you mean 'gain'?), 'xyz'"
    check_names(['gain'], {'loop': 'gain'})
    with pytest.raises(ValueError, match=r'^loop is now gain: give that one'):
        check_names(['loop'], {'loop': 'gain'})


def test_arrays_are_lists_to_ros():
    assert plain((1.0, 2.0)) == [1.0, 2.0] and plain('a') == 'a'


def test_infinity_may_stand_beside_a_range():
    walk = ParameterSpec('walk', 0.0, 'a walk', lower=0.0, upper=5.0, infinite=True)
    assert walk.coerce(math.inf) == math.inf and walk.coerce(5) == 5.0
    assert walk.range == '0 to 5, or inf'
    for wrong in (5.1, -math.inf, math.nan, -1.0):
        with pytest.raises(ValueError, match=r'^walk must be 0 to 5, or inf, not '):
            walk.coerce(wrong)
