"""Fields of a Variable are checked by name."""

import pytest

from obs_ros.core.variable_fields import (
    SENSOR_FIELDS,
    check_kind,
    checked_prior,
    checked_sensor_field,
    number,
)


def test_a_number_is_a_float_and_no_truth() -> None:
    assert number('x', 3) == 3.0 and isinstance(number('x', 3), float)
    for wrong in (True, '3', None, 10**400):
        with pytest.raises(ValueError, match=r'^x must be a number, not '):
            number('x', wrong)


def test_texts_from_outside_are_shortened() -> None:
    with pytest.raises(ValueError) as caught:
        checked_sensor_field('level', 'range', 'x' * 10_000)
    assert len(str(caught.value)) < 300


def test_each_field_says_by_which_kinds_it_is_had() -> None:
    kinds = ('state', 'input', 'output', 'parameter')
    allowed = {
        (field, kind) for field in SENSOR_FIELDS for kind in kinds if kind in SENSOR_FIELDS[field]
    }
    for field in SENSOR_FIELDS:
        for kind in kinds:
            if (field, kind) in allowed:
                check_kind('v', kind, [field])
            else:
                with pytest.raises(
                    ValueError, match=f'v is one of the {kind}s, but only .* {field}'
                ):
                    check_kind('v', kind, [field])


def test_a_prior_on_a_log_scale_has_a_positive_mean() -> None:
    assert checked_prior('k', [-1, 2], log=False) == (-1.0, 2.0)
    with pytest.raises(ValueError, match=r'k: prior mean -1.0 must be positive on a log scale'):
        checked_prior('k', [-1, 2], log=True)
