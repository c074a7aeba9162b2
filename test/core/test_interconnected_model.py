import math
from dataclasses import replace

import pytest

from obs_ros.models.heat_exchanger import HEAT_EXCHANGER, HEAT_EXCHANGER_REDUCED


def test_openings_and_their_rates_are_found_by_name() -> None:
    assert HEAT_EXCHANGER.opening_index == (4, 2)
    assert HEAT_EXCHANGER.rate_index == (5, 3)
    assert HEAT_EXCHANGER_REDUCED.opening_index == (3, 2)
    assert HEAT_EXCHANGER_REDUCED.rate_index == ()


@pytest.mark.parametrize(
    ('changes', 'why'),
    [
        ({'openings': ('X2',)}, 'openings has 1 entries for 2 outputs'),
        ({'openings': ('X2', 'Tp')}, "'Tp' is none of the actuator states X1, V1, X2, V2"),
        ({'opening_rates': ('V2',)}, 'opening_rates has 1 entries, not 2 or none'),
        ({'openings': ('X1', 'X2')}, 'but dynamics says'),
        ({'drift': lambda t, x, u, p: (0.0, 0.0)}, r'f \+ g F is'),
        (
            {'kind': 'discrete', 'period': 0.1, 'max_step': math.inf},
            'flows feed rates, which no discrete model has',
        ),
        ({'output': lambda t, x, u, p: (x[1], x[0])}, 'outputs must be the first 2 states'),
    ],
)
def test_parts_that_are_at_odds_are_refused(changes: dict[str, object], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        replace(HEAT_EXCHANGER, **changes)
