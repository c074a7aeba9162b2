import pytest
from ball_and_beam import BALL
from hypothesis import given
from hypothesis import strategies as st

from obs_ros import Model, Variable
from obs_ros.replay.table import LONGEST_ROW, Table


def write(tmp_path, text, name='a.csv'):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read(path, columns=None, period=None, model=BALL):
    return [
        (s.stamp, None if s.u is None else s.u.tolist(), None if s.y is None else s.y.tolist())
        for s in Table(path, columns or {}, period, model)
    ]


def test_each_row_is_an_input_then_an_output(tmp_path):
    path = write(tmp_path, 'note,y,t,u\nx,1.5,0.25,2\ny,-2,0.5,3e-1\n')
    assert read(path) == [
        (250_000_000, [2.0], None),
        (250_000_000, None, [1.5]),
        (500_000_000, [0.3], None),
        (500_000_000, None, [-2.0]),
    ]
    assert Table(path, {}, None, BALL).remarks == ['columns that the model does not know: note']


def test_rows_without_time_are_a_period_apart(tmp_path):
    stamps = [s for s, *_ in read(write(tmp_path, 'u,y\n' + '1,2\n' * 4), period=0.1)]
    assert stamps[::2] == [0, 100_000_000, 200_000_000, 300_000_000]


@pytest.mark.parametrize(
    ('name', 'text', 'stamp'),
    [
        ('t', '1700000000.123456789', 1_700_000_000_123_456_789),
        ('time', '2', 2 * 10**9), ('stamp', '0', 0), ('time_s', '1e-9', 1),
        ('t_ms', '5.5', 5_500_000), ('stamp_us', '7', 7_000),
        ('t_ns', '1700000000123456789', 1_700_000_000_123_456_789),
    ],
)  # fmt: skip
def test_the_name_of_the_time_tells_its_unit(tmp_path, name, text, stamp):
    assert read(write(tmp_path, f'{name},u,y\n{text},1,2\n'))[0][0] == stamp


def test_columns_have_other_names_where_that_is_said(tmp_path):
    path = write(tmp_path, 'clock_ms;angle;position\n10;1;2\n')
    columns = {'t': 'clock_ms', 'u': 'angle', 'y': 'position'}
    assert read(path, columns) == [(10_000_000, [1.0], None), (10_000_000, None, [2.0])]


def test_an_input_and_an_output_of_one_name_need_two_columns(tmp_path):
    def twin(t, x, u, p):
        return (u[0] - x[0],)

    model = Model('m', (Variable('x'),), (Variable('h'),), twin, lambda t, x, u, p: (x[0],),
                  inputs=(Variable('h'),))  # fmt: skip
    path = write(tmp_path, 't,h,h_out\n1,2,3\n')
    with pytest.raises(ValueError, match=r"'h' is wanted twice: say with --column input.NAME="):
        Table(path, {}, None, model)
    assert read(path, {'output.h': 'h_out'}, model=model)[1] == (10**9, None, [3.0])


def test_what_was_not_measured_is_left_out(tmp_path):
    path = write(
        tmp_path, '\ufefft\tu\ty\n# a remark\n\n1\t\t2\n2\tnan\tNaN\n3\t4\t"5"\r\n', 'a.tsv'
    )
    assert read(path) == [(10**9, None, [2.0]), (3 * 10**9, [4.0], None), (3 * 10**9, None, [5.0])]


@pytest.mark.parametrize(
    ('text', 'columns', 'period', 'message'),
    [
        ('', {}, 0.1, ":1: no column is called 'u'"),
        ('u,y\n1,2\n', {}, None, r':1: no column is called t, time, stamp .*--period'),
        ('t,u,y\n1,2,3\n', {}, 0.1, "'t' tells the time already"),
        ('u,y\n1,2\n', {}, -1.0, 'the period -1.0 s is not a time'),
        ('u,y\n1,2\n', {}, float('nan'), 'the period nan s is not a time'),
        ('t,time,u,y\n', {}, None, "'t' and 'time' may both be the time"),
        ('t,u,u,y\n', {}, None, "more than one column is called 'u'"),
        ('t,u,position\n', {}, None, "no column is called 'y': .*--column NAME=COLUMN"),
        ('t,u,y\n', {'z': 'u'}, None, '--column z=: the model has no such input or output'),
        ('t,u,y\n', {'y': 'Y'}, None, "no column is called 'Y': known are t, u, y"),
        ('t,u,y\n1,2,3\n1,2\n', {}, None, 'a.csv:3: 2 fields, but 3 columns'),
        ('t,u,y\n1,2,three\n', {}, None, "a.csv:2: 'three' is not a number"),
        ('t,u,y\n1,2_0,3\n', {}, None, "a.csv:2: '2_0' is not a number"),
        ('t,u,y\n\n,2,3\n', {}, None, "a.csv:3: the time is '', not a number"),
        ('t,u,y\n-1,2,3\n', {}, None, 'a.csv:2: the time -1 is outside'),
        ('t,u,y\n1e300,2,3\n', {}, None, r'a.csv:2: the time 1e\+300 is outside'),
        ('t,u,y\n1e999999999,2,3\n', {}, None, 'a.csv:2: the time is .* not a number'),
        ('t,u,y\n1,"2,3\n', {}, None, 'a.csv:2: '),
        (b't,u,y\n1,2,\xff\n', {}, None, 'a.csv:2: save the table as UTF-8: byte 0xff'),
        (b't,u,y [\xb0C]\n', {}, None, 'a.csv:1: save the table as UTF-8: byte 0xb0'),
        ('t,u,y\n' + '1' * LONGEST_ROW + '\n', {}, None, 'a.csv:2: the row is longer than'),
        ('t' * (LONGEST_ROW + 1), {}, None, f'a.csv:1: the row is longer than {LONGEST_ROW}'),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_place(tmp_path, text, columns, period, message):
    with pytest.raises(ValueError, match=message):
        read(write(tmp_path, text), columns, period)


def test_a_row_without_end_is_not_read_into_memory(tmp_path):
    path = tmp_path / 'a.csv'
    with path.open('wb') as file:
        file.write(b't,u,y\n1,2,3\n')
        file.truncate(2**40)  # holes, no disk
    with pytest.raises(ValueError, match=r'a.csv:3: the row is longer'):
        read(path)


@given(st.binary(max_size=300))
def test_any_bytes_give_samples_or_a_value_error(tmp_path_factory, garbage):
    path = tmp_path_factory.getbasetemp() / 'garbage.csv'
    path.write_bytes(b't,u,y\n' + garbage)
    try:
        for stamp, *_ in read(path):
            assert 0 <= stamp < 2**31 * 10**9
    except ValueError as error:
        assert 'garbage.csv:' in str(error)
