"""Tables, requirements and texts of reports, and the runner."""

import re
from string import Formatter

import numpy as np
import pytest

from benchmarks import report
from benchmarks.intervals import confidently_wrong, coverage, difference_interval
from benchmarks.report import Requirement, filled, pictures, publish, requirements, rms, table
from benchmarks.runner import ROOT, _Place, monte_carlo, progress

PAGES = [p for p in (ROOT / 'benchmarks').glob('*/**/*.md') if p.parent.name != 'results']


def test_a_requirement_is_judged_as_it_is() -> None:
    rows = [Requirement('a <= 1', '0.9', True), Requirement('b <= 1', '1.001', False)]
    assert requirements(rows).splitlines() == [
        '| asked | measured | met |',
        '| --- | --- | --- |',
        '| a <= 1 | 0.9 | yes |',
        '| b <= 1 | 1.001 | **no** |',
    ]
    assert requirements([]) == table(iter([])) == 'None.'


def test_places_that_stay_empty_leave_no_gap(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(report, '__file__', str(tmp_path / 'report.py'))
    (tmp_path / 'page.md').write_text('{a}\n\n{b}\n\n{c:.1f} ms\n\n{d}\n')
    assert filled('page', a='one', b='', c=0.25, d='') == 'one\n\n0.2 ms'


@pytest.mark.parametrize('page', PAGES, ids=lambda page: f'{page.parent.name}/{page.name}')
def test_every_place_of_a_page_is_filled(page) -> None:
    fields = [name for _, name, _, _ in Formatter().parse(page.read_text()) if name]
    places = {re.split(r'[.[]', name)[0] for name in fields}
    source = '\n'.join(path.read_text() for path in page.parent.glob('*.py'))
    assert places
    for name in places:
        assert re.search(rf"\b{name}=|'{name}'", source), name


def test_a_report_is_kept_with_its_machine(tmp_path, capsys) -> None:
    text = publish(tmp_path, 'name', 'Title', 'Text.', 'gcc 1')
    assert text == (tmp_path / 'name.md').read_text() == capsys.readouterr().out[:-1]
    head, machine, body = text.strip().split('\n\n')
    assert (head, body) == ('# Title', 'Text.')
    assert machine.endswith(', gcc 1') and f'numpy {np.__version__}' in machine


def test_without_matplotlib_a_report_says_so(tmp_path) -> None:
    def draw() -> None:
        raise ImportError('no matplotlib')

    assert pictures(tmp_path, {'a.png': ('title', draw)}) == 'No pictures: no matplotlib.'


def test_the_runner_keeps_cells_and_order() -> None:
    cells = {'a': [(7, 2), (9, 4)], 'b': [(1, 1)], 'c': []}
    assert monte_carlo(divmod, cells, 'divide') == {'a': [(3, 1), (2, 1)], 'b': [(1, 0)], 'c': []}


def test_progress_is_told_to_a_terminal_only(capsys, monkeypatch) -> None:
    assert list(progress('abc', 'letters', 3)) == ['a', 'b', 'c']
    assert capsys.readouterr().err == ''
    monkeypatch.setattr('sys.stderr.isatty', lambda: True)
    assert list(progress('abc', 'letters', 3)) == ['a', 'b', 'c']
    assert 'letters: 3/3' in capsys.readouterr().err


def test_intervals_are_counted_where_they_are_given() -> None:
    error, sd = np.array([0.0, 0.1, 0.5, 0.5]), np.array([0.1, 0.04, 0.1, np.nan])
    assert coverage(error, sd) == pytest.approx(1.0 / 3.0)
    assert np.isnan(coverage(error, sd * np.nan))
    assert confidently_wrong(error, sd).tolist() == [False, False, True, False]
    # An error within 2 % of the box is no matter, however sure.
    assert not confidently_wrong(0.02, 1e-6)


def test_the_root_mean_square_goes_along_an_axis() -> None:
    values = np.array([[3.0, 0.0], [4.0, 0.0]])
    assert rms(values[:, 0]) == pytest.approx(np.sqrt(12.5))
    np.testing.assert_allclose(rms(values, 0), [np.sqrt(12.5), 0.0])


def test_a_difference_of_shares_has_its_interval() -> None:
    """56 of 70 against 48 of 80: Newcombe 1998 has 0.0524 to 0.3339 with intervals of Wilson."""
    low, high = difference_interval((48, 80), (56, 70))
    assert low == pytest.approx(0.0524, abs=0.015) and high == pytest.approx(0.3339, abs=0.015)
    assert low < 0.0524 and high > 0.3339  # intervals of Clopper and Pearson are wider
    assert difference_interval((56, 70), (48, 80)) == pytest.approx((-high, -low))
    assert difference_interval((0, 200), (0, 200)) == pytest.approx((-0.01828, 0.01828), abs=1e-5)


def stopped_at(number: int) -> int:
    if number == 2:
        raise KeyboardInterrupt
    return number


def test_runs_that_are_stopped_tell_how_many_are_done(monkeypatch, capsys) -> None:
    monkeypatch.setitem(_Place.chosen, 'jobs', None)  # here
    with pytest.raises(KeyboardInterrupt):
        monte_carlo(stopped_at, {'a': [(0,), (1,)], 'b': [(2,), (3,)]}, 'numbers')
    assert 'numbers: stopped after 2 of 4 runs' in capsys.readouterr().err
