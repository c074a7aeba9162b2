import io

import pytest

from obs_ros.studies import progress as module
from obs_ros.studies.progress import Progress, duration, progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands until it is set."""
    now = [0.0]
    monkeypatch.setattr(module.time, 'monotonic', lambda: now[0])
    return now


def test_a_terminal_gets_a_bar_with_rate_and_time_left(clock):
    stream = Terminal()
    shown = Progress('replay', 200, stream)
    for done in range(1, 51):
        clock[0] = 0.5 * done
        shown.step()
    last = stream.getvalue().split('\r')[-1].rstrip()
    assert last == 'replay: 50/200 [#####...............], 2/s, 75 s to go'
    assert '\n' not in stream.getvalue()
    shown.say('a line')
    assert stream.getvalue().split('\r')[-1] == f'{"a line":<78}'.rstrip() + '\n'


def test_the_bar_is_drawn_no_more_often_than_anybody_sees(clock):
    stream = Terminal()
    shown = Progress('replay', 10_000, stream)
    for done in range(1, 10_000):
        clock[0] = 1e-3 * done
        shown.step()
    assert stream.getvalue().count('\r') <= 10.0 / module.REFRESH
    shown.step()
    last = stream.getvalue().split('\r')[-1]
    assert '10000/10000' in last and last.endswith('\n')


def test_what_is_no_terminal_gets_lines_now_and_then_or_nothing(clock):
    lines, nothing = io.StringIO(), io.StringIO()
    shown = Progress('replay', 40, lines, lines=True), Progress('replay', 40, nothing)
    for done in range(1, 41):
        clock[0] = float(done)
        for each in shown:
            each.step()
    told = lines.getvalue().splitlines()
    assert told[0] == 'replay: 10/40, 1/s, 30 s to go'
    assert told[-1] == 'replay: 40/40, 1/s, done'
    assert len(told) == 4
    assert nothing.getvalue() == ''


@pytest.mark.parametrize(
    ('seconds', 'words'), [(0.0, '0 s'), (99.0, '99 s'), (720.0, '12 min'), (12000.0, '3 h 20 min')]
)
def test_times_are_told_as_people_do(seconds, words):
    assert duration(seconds) == words


def test_items_are_handed_on_as_they_are(capsys):
    assert list(progress('abc', 'letters', 3)) == ['a', 'b', 'c']
    assert capsys.readouterr().err == ''
