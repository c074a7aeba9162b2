"""Tests of obs_ros.inference.outlier_count."""

from obs_ros.inference.outlier_count import TOLD, OutlierCount, newest, words
from obs_ros.inference.window_state import Outlier

OUTPUTS = ('h1', 'h2')
BURST = tuple(Outlier(20.0 + k, 1, 9.0 + k, 20.0) for k in range(5))


def test_each_sample_is_counted_once_however_many_windows_hold_it() -> None:
    count = OutlierCount(OUTPUTS)
    first, second = Outlier(12.0, 0, 9.0), Outlier(12.0, 1, 8.0)
    count.note((first, second), 0.0)
    count.note((first, Outlier(31.0, 0, 7.0)), 10.0)
    count.note((), 40.0)
    assert count.counts == {'outlier.h1': 2, 'burst.h1': 0, 'outlier.h2': 1, 'burst.h2': 0}


def test_a_burst_is_counted_once_even_if_the_next_window_holds_a_part_of_it() -> None:
    count = OutlierCount(OUTPUTS)
    count.note(BURST, 0.0)
    count.note([Outlier(o.time, 1, o.size, 22.0) for o in BURST[2:]], 22.0)
    count.note([Outlier(40.0, 1, 9.0, 40.0)], 30.0)
    assert count.counts == {'outlier.h1': 0, 'burst.h1': 0, 'outlier.h2': 0, 'burst.h2': 2}


def test_words_name_the_largest_with_time_and_size() -> None:
    one = (Outlier(12.3, 1, 10.2),)
    assert words(one, OUTPUTS) == ['1 outlier of h2 at 12.30 s (10.2 sigma) left out']
    many = [Outlier(float(i), 0, 6.0 + i) for i in range(TOLD + 1)]
    (said,) = words(many, OUTPUTS)
    assert said.startswith(f'{len(many)} outliers of h1 at 3.00 s (9 sigma), 2.00 s (8 sigma)')
    assert said.endswith('and others left out')
    assert words((), OUTPUTS) == []


def test_words_name_the_sensor_of_a_burst() -> None:
    said = words([*BURST, Outlier(3.0, 1, 7.0)], OUTPUTS)
    assert said == [
        '1 outlier of h2 at 3.00 s (7 sigma) left out',
        'look at the sensor of h2: a burst of 5 values from 20.00 s to 24.00 s, up to 13 sigma, '
        'counts as not measured',
    ]


def test_the_newest_is_told() -> None:
    assert newest([*BURST, Outlier(3.0, 0, 70.0)], OUTPUTS) == 'h2 at 24.00 s (13 sigma)'
    assert newest((), OUTPUTS) == ''
