import tracemalloc

import pytest

from obs_ros.cli.package_signals import Signal, Signals, of_header
from obs_ros.cli.recorded_ranges import Range, assumed, header_of, recorded


def table(folder, rows, header='t,cur,volt', name='a.csv'):
    path = folder / name
    path.write_text('\n'.join([header, *rows]) + '\n')
    return path


def signals_of(path):
    return of_header(header_of(path), {}, [Signal('cur')], [])


def test_lowest_highest_and_mean_of_what_was_measured(tmp_path):
    rows = [f'{0.5 * k},{k},{"" if k % 2 else -k}' for k in range(40)]
    path = table(tmp_path, rows)
    found = recorded(path, signals_of(path), None)
    assert found.inputs == (Range(0.0, 39.0, 19.5),)
    assert found.outputs == (Range(-38.0, 0.0, -19.0),)
    assert (found.period, found.duration) == (0.5, 19.5)


def test_a_table_without_time_has_the_period_that_is_given(tmp_path):
    path = table(tmp_path, [f'{k},1' for k in range(21)], 'cur,volt')
    found = recorded(path, signals_of(path), 0.1)
    assert (found.period, found.duration) == (pytest.approx(0.1), pytest.approx(2.0))


def test_rows_that_repeat_a_time_are_one_sample(tmp_path):
    rows = [row for k in range(40) for row in (f'{k},1,', f'{k},,2')]
    found = recorded(path := table(tmp_path, rows), signals_of(path), None)
    assert (found.period, found.duration) == (1.0, 39.0)


def test_a_long_table_takes_no_more_memory_than_a_short_one(tmp_path):
    peaks = []
    for count in (500, 500, 5000):  # once to load what is loaded once
        path = table(tmp_path, [f'{k},1,2' for k in range(count)])
        signals = signals_of(path)
        tracemalloc.start()
        recorded(path, signals, None)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] < 1.5 * peaks[1]


def test_a_signal_that_never_moves_has_the_span_of_its_value():
    assert [Range(v, v, v).span for v in (4.0, -4.0, 0.0)] == [4.0, 4.0, 1.0]


def test_without_a_table_the_ranges_are_assumed():
    found = assumed(Signals((Signal('a'),), (Signal('b'), Signal('c'))), 2.0)
    assert len(found.inputs) == 1 and len(found.outputs) == 2
    assert (found.period, found.duration) == (2.0, 2000.0)


@pytest.mark.parametrize(
    ('rows', 'words'),
    [
        ([], 'record more, in order of time: .*a.csv has 0 rows'),
        ([f'{-k + 50},1,2' for k in range(40)], 'has 1 rows whose time goes on'),
        ([f'{k},1,2' for k in range(19)], 'has 19 rows'),
        (['0,1,2'] * 30, 'has 1 rows'),
        ([f'{k},1,nan' for k in range(30)], 'leave volt out: .* has no value of it'),
        ([f'{k},1,inf' for k in range(30)], 'leave volt out'),
        ([f'{k},x,2' for k in range(30)], "a.csv:2: 'x' is not a number"),
        ([f'{k},1,{k}e300' for k in range(30)], 'give volt another unit.* 0 to 2.9e'),
        ([f'{k * 1e-9:.9f},1,2' for k in range(30)], 'record for longer: windows have 0.001 s'),
        (['0,1'], 'a.csv:2: 2 fields, but 3 columns'),
    ],
)
def test_a_table_that_tells_nothing_is_refused(tmp_path, rows, words):
    path = table(tmp_path, rows)
    with pytest.raises(ValueError, match=words):
        recorded(path, signals_of(path), None)


def test_what_is_no_table_is_refused(tmp_path):
    (tmp_path / 'empty.csv').touch()
    with pytest.raises(ValueError, match=r'first row names its columns: .* is empty'):
        header_of(tmp_path / 'empty.csv')
    for name in ('.', 'a.mcap'):
        (tmp_path / 'a.mcap').touch()
        with pytest.raises(ValueError, match='give a table, which ends in'):
            header_of(tmp_path / name)
    with pytest.raises(FileNotFoundError, match=r"did you mean 'empty.csv'"):
        header_of(tmp_path / 'empt.csv')
