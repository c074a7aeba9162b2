"""Tests of obs_ros.observers.settings."""

from dataclasses import dataclass

import numpy as np
import pytest

from obs_ros.observers.settings import Settings, parameter_specs, setting, settings_of


@dataclass(frozen=True)
class Own(Settings):
    gain: float = setting(2.0, 'of the correction', '1/s', lower=0.0, upper=10.0)
    mode: str = setting('fast', 'of the search', choices=('fast', 'slow'))


def test_the_table_has_the_shared_settings_and_its_own_with_units_and_limits() -> None:
    rows = {spec.name: spec for spec in parameter_specs(Own, 'my.')}
    assert list(rows) == [
        'my.longest_gap', 'my.innovation_gate', 'my.gate_patience', 'my.gain', 'my.mode',
    ]  # fmt: skip
    assert (rows['my.gain'].default, rows['my.gain'].unit) == (2.0, '1/s')
    assert rows['my.mode'].choices == ('fast', 'slow')


def test_values_are_taken_as_the_table_says() -> None:
    own = settings_of(Own, {'gain': np.float64(3), 'longest_gap': 5})
    assert own == Own(longest_gap=5.0, gain=3.0)
    assert type(own.gain) is float and type(own.longest_gap) is float


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({'gian': 1.0}, "unknown setting 'gian': did you mean 'gain'"),
        ({'gain': 11.0}, 'gain'),
        ({'mode': 'medium'}, 'mode'),
    ],
)
def test_wrong_ones_are_refused_by_name(given: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        settings_of(Own, given)
