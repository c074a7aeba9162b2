"""`make demo` as a user runs it, and what it says of what it got."""

import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from patience import patience

from demo.jumps import Announced, found_as_true, merged, noted
from demo.pacing import runs_on

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.slow
def test_demo_finds_every_valve_and_draws_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if 'AMENT_PREFIX_PATH' not in os.environ:
        monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)
    packages = pytest.importorskip('ament_index_python.packages')
    pytest.importorskip('matplotlib')
    try:
        packages.get_package_prefix('obs_ros')
    except packages.PackageNotFoundError:
        pytest.skip('obs_ros is not installed in a prefix of AMENT_PREFIX_PATH')
    picture = tmp_path / 'demo.png'
    run = subprocess.run(
        [sys.executable, '-m', 'demo.three_tank', '--picture', str(picture)],
        cwd=ROOT,
        env={**os.environ, 'PYTHONPATH': str(ROOT), 'PYTHONUNBUFFERED': '1'},
        capture_output=True,
        text=True,
        timeout=patience(60.0),
    )
    assert run.returncode == 0, run.stdout + run.stderr
    jumps = run.stdout.split('found to have jumped')[1]
    assert jumps.count(' by ') == 4
    assert picture.read_bytes()[:4] == b'\x89PNG'


TRUTH = {1000.0: {'p1', 'p2'}, 2000.0: {'p1', 'p3'}}


def at(seconds: float) -> int:
    return round(seconds * 1e9)


def announced_at(jumps: dict[float, dict[str, float]]) -> dict[int, Announced]:
    """Return announcements by stamp of sizes by time (s), each with the same doubts."""
    return {
        at(time): Announced(sizes, dict.fromkeys(sizes, 0.01), 0.9) for time, sizes in jumps.items()
    }


def test_one_jump_announced_in_two_pieces_is_one() -> None:
    pieces = {999.8: {'p1': -0.3}, 1000.4: {'p2': -0.5}, 2000.1: {'p3': -0.5}, 1999.6: {'p1': -0.3}}
    found = merged(announced_at(pieces))
    sizes = [(time, jump.sizes) for time, jump in found]
    assert sizes == [(999.8, {'p1': -0.3, 'p2': -0.5}), (1999.6, {'p1': -0.3, 'p3': -0.5})]
    assert found_as_true(found, TRUTH)


def test_a_jump_is_one_line_with_deviations_and_the_least_probability() -> None:
    jump = Announced({'p1': -0.3}, {'p1': 0.002}, 0.999).joined(
        Announced({'p2': 0.5}, {'p2': 0.01}, 0.97)
    )
    assert str(jump) == 'p1 by -0.3000 ± 0.0040, p2 by +0.5000 ± 0.0200, probability 0.97'
    assert str(Announced({'p1': -0.3}, {'p1': 0.002}, math.nan)) == 'p1 by -0.3000 ± 0.0040'


def test_sizes_of_nothing_take_back_what_was_announced_for_the_stamp() -> None:
    announced: dict[int, Announced] = {}
    both, nothing = {'p1': -0.3, 'p2': -0.5}, {'p2': 0.0}
    for stamp, sizes in ((1, both), (1, nothing), (2, {'p2': 1.0}), (2, nothing), (3, nothing)):
        noted(announced, stamp, Announced(sizes, dict.fromkeys(sizes, 0.01), 0.9))
    assert {stamp: jump.sizes for stamp, jump in announced.items()} == {1: {'p1': -0.3}}
    noted(announced, 1, Announced({'p3': 0.2}, {'p3': 0.01}, 0.5))
    assert announced[1].sizes == {'p1': -0.3, 'p3': 0.2} and announced[1].probability == 0.5


@pytest.mark.parametrize(
    'announced',
    [
        {1000.0: {'p1', 'p2'}},
        {1000.0: {'p1', 'p2'}, 1500.0: {'p2'}, 2000.0: {'p1', 'p3'}},
        {1000.0: {'p1'}, 2000.0: {'p1', 'p3'}},
        {1000.0: {'p1', 'p2'}, 2001.5: {'p1', 'p3'}},
        # Too far apart to be one.
        {1000.0: {'p1'}, 1003.0: {'p2'}, 2000.0: {'p1', 'p3'}},
    ],
    ids=['one missing', 'one too many', 'half of one', 'late', 'pieces apart'],
)
def test_jumps_that_were_not_are_not_right(announced: dict[float, set[str]]) -> None:
    sizes = {time: dict.fromkeys(names, 1.0) for time, names in announced.items()}
    found = merged(announced_at(sizes))
    assert not found_as_true(found, TRUTH)


def recorded(
    outcome: str, message: str, *, error: float, deviation: float = 0.001, windows: int = 2
) -> SimpleNamespace:
    """Return what came for windows of 100 s each, the first of them off by `error`."""
    from demo.recorder import Verdict

    levels, openings = {'h1': 10.0}, {'p1': 0.5}
    stamps = [at(100.0 * k) for k in range(1, windows + 1)]
    converged = dict.fromkeys(stamps, Verdict('converged', 'white'))
    return SimpleNamespace(
        verdicts={**converged, stamps[0]: Verdict(outcome, message)},
        received={
            'truth': dict.fromkeys(stamps, levels),
            'true_parameters': {0: openings, **dict.fromkeys(stamps, openings)},
            'state': dict.fromkeys(stamps, levels),
            'parameters': {**dict.fromkeys(stamps, openings), stamps[0]: {'p1': 0.5 + error}},
            'state_stddev': {s: {'h1': math.nan} for s in stamps},
            'parameters_stddev': {s: {'p1': deviation} for s in stamps},
        },
        intervals={s: {'p1': (0.4375, 0.875)} for s in stamps},
    )


def judged(recorder: SimpleNamespace) -> bool:
    pytest.importorskip('rclpy')
    from demo.three_tank import conclude, report

    seen = sorted(recorder.verdicts)
    return conclude(recorder, seen, [report(recorder, stamp, shown=False) for stamp in seen])


def test_a_window_that_is_off_is_quoted_with_its_own_outcome(capsys) -> None:
    assert not judged(recorded('at_bound', 'p1 at its bound', error=0.1))
    streams = capsys.readouterr()
    assert 'the window up to 100 s is off, and says at_bound: p1 at its bound' in streams.err
    assert 'more than 0.01 off' in streams.out and '200' not in streams.err
    assert '0.43750    0.87500   more than 0.01 off' in streams.out, 'the interval as published'


@pytest.mark.parametrize(
    ('deviation', 'windows', 'good'),
    [(0.04, 20, True), (0.02, 20, False), (math.nan, 20, False), (0.04, 5, False)],
    ids=['as far as it says', 'further', 'it does not say', 'too often'],
)
def test_a_window_may_be_as_far_off_as_it_says(
    deviation: float, windows: int, good: bool, capsys
) -> None:
    assert (
        judged(recorded('converged', 'white', error=0.1, deviation=deviation, windows=windows))
        == good
    )
    assert 'more than 0.01 off' in capsys.readouterr().out


def test_a_window_that_the_node_withheld_is_not_held_against_it(capsys) -> None:
    assert judged(recorded('deadline', 'no time', error=0.1))
    assert '2 estimates, 1 of which the node stands by' in capsys.readouterr().out


def test_a_node_that_stands_by_too_little_is_not_well(capsys) -> None:
    recorder = recorded('deadline', 'no time', error=0.0)
    recorder.verdicts = dict.fromkeys(recorder.verdicts, recorder.verdicts[at(100.0)])
    assert not judged(recorder)
    assert 'stands by too few; its last doubt: deadline: no time' in capsys.readouterr().err


def test_the_plant_waits_for_whoever_is_behind() -> None:
    running = True
    for plant, newest, runs in [
        (250.0, 0.0, True), (400.0, 0.0, True), (401.0, 0.0, False), (420.0, 300.0, False),
        (420.0, 400.0, True), (440.0, 400.0, True), (440.0, 550.0, False), (520.0, 550.0, True),
    ]:  # fmt: skip
        running = runs_on(running, plant, newest, window=300.0, period=50.0)
        assert running == runs, (plant, newest)
