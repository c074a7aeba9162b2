"""Tests of benchmarks.sequence.jumps_elsewhere."""

import numpy as np
import pytest

from benchmarks.intervals import COVERED, share_interval
from benchmarks.runner import ROOT
from benchmarks.sequence.__main__ import main
from benchmarks.sequence.jumps_elsewhere import scores
from benchmarks.sequence.jumps_elsewhere.acceptance import asked
from benchmarks.sequence.jumps_elsewhere.follow import Followed, Said, followed
from benchmarks.sequence.jumps_elsewhere.judged import (
    How,
    after,
    calm,
    false_jumps,
    settled,
    told,
    verdicts,
)
from benchmarks.sequence.jumps_elsewhere.rates import clustered, resampled
from benchmarks.sequence.jumps_elsewhere.run import Cell, Measured
from benchmarks.sequence.jumps_elsewhere.scenes import (
    KINDS,
    OUTLIER,
    PLANTS,
    Scene,
    noise,
    run_of,
)
from benchmarks.sequence.jumps_elsewhere.truth import Course, trajectory
from benchmarks.sequence.jumps_elsewhere.unmodelled import UNMODELLED
from benchmarks.sequence.jumps_elsewhere.visible import visible
from benchmarks.sequence.plants import Change, Parameters
from benchmarks.zoo.experiments import EXPERIMENTS
from obs_ros.core.model import names

WINDOWS = 8
NAMES = names(EXPERIMENTS['motor'].model.parameters)


def said(name: str, time: float, **changed: object) -> Said:
    """A new jump of the motor's parameters, at this many window lengths."""
    made = Said(frozenset(name.split()), time, 0.01, 5.0, (), True, np.nan, False)
    return made._replace(**changed)


def made(*jumps: tuple[int, Said], changes: tuple[Change, ...] = ()) -> Followed:
    """A run of the motor whose windows, of 1 s, report these jumps, and nothing but the truth."""
    end = 1.0 + np.arange(WINDOWS)
    zero = np.zeros((WINDOWS, 7))
    return Followed(
        scene=Scene('motor', 'jump', True, 1, WINDOWS),
        begin=end - 1.0,
        end=end,
        error=zero,
        lower=zero - 1.0,
        upper=zero + 1.0,
        accepted=np.ones(WINDOWS, dtype=bool),
        outcomes=('converged',) * WINDOWS,
        said=tuple(tuple(one for k, one in jumps if k == window) for window in range(WINDOWS)),
        drifting=((),) * WINDOWS,
        changes=changes,
        moving='',
        spoiled=np.zeros(WINDOWS, dtype=bool),
        pushed=np.arange(WINDOWS) == 4,
        seconds=np.ones(WINDOWS),
        visible=np.full(WINDOWS, np.inf),
    )


JUMP = Change(3.5, 1, 10.0)  # of the inductance, in window 3


def test_the_truth_of_a_lag_is_that_of_its_formula():
    t = np.arange(0.0, 6.05, 0.1)
    u = np.where(t < 1.95, 1.0, 3.0)[:, None]
    course = Course(Parameters.of(np.array([2.0]), [Change(4.03, 0, 2.0)]))
    x = trajectory(lambda t, x, u, p: [(u[0] - x[0]) / p[0]], t, u, np.zeros(1), course)[:, 0]
    first = 1.0 - np.exp(-t / 2.0)
    second = 3.0 - (3.0 - (1.0 - np.exp(-1.0))) * np.exp(-(t - 2.0) / 2.0)
    third = 3.0 - (2.0 + np.exp(-1.0)) * np.exp(-2.03 / 2.0) * np.exp(-(t - 4.03) / 4.0)
    expected = np.where(t < 2.05, first, np.where(t < 4.03, second, third))
    np.testing.assert_allclose(x, expected, atol=1e-9)


def test_a_parameter_that_oscillates_does_so_in_the_truth():
    t = np.arange(0.0, 5.05, 0.1)
    course = Course(Parameters.of(np.ones(1)), factor=lambda t: 1.0 + 0.5 * np.sin(3.0 * t))
    x = trajectory(lambda t, x, u, p: [p[0]], t, np.empty((t.size, 0)), np.zeros(1), course)
    np.testing.assert_allclose(x[:, 0], t + (1.0 - np.cos(3.0 * t)) / 6.0, atol=1e-8)


@pytest.mark.parametrize('plant', PLANTS)
def test_jumps_are_of_the_size_that_is_said_and_stay_in_the_box(plant):
    for seed in range(6):
        scene = Scene(plant, 'jump', False, seed, 12)
        run = run_of(scene)
        assert len(run.changes) == (2 if seed % 3 == 0 else 1)
        before = run.p[0].copy()
        for change in run.changes:
            share = abs(change.size) / before[change.place]
            assert 0.15 <= share <= 0.40
            before[change.place] += change.size
            assert 3.0 <= change.time / scene.length <= 11.0
        np.testing.assert_allclose(run.p[-1], before)
        for p, box in zip(run.p.T, scene.experiment.model.parameters, strict=True):
            assert box.lower < p.min() <= p.max() < box.upper


@pytest.mark.parametrize('kind', KINDS)
def test_a_run_is_the_same_again_and_its_windows_share_their_ends(kind):
    scene = Scene('van der Pol', kind, False, 4, 9)
    one, two = run_of(scene), run_of(scene)
    np.testing.assert_array_equal(one.y, two.y)
    records = one.records()
    assert len(records) == 9
    assert records[1].t[0] == records[0].t[-1] == scene.length
    assert (np.ptp(one.p, axis=0) > 0.0).sum() == (
        1 if KINDS[kind].ramp or KINDS[kind].oscillates or KINDS[kind].jumps else 0
    )


def test_a_parameter_oscillates_inside_a_window_by_15_percent_and_a_ramp_ends():
    run = run_of(Scene('cells', 'oscillating', True, 1, 3))
    place = int(np.ptp(run.p, axis=0).argmax())
    moved = run.p[:301, place]
    assert moved.max() / moved.min() == pytest.approx(1.15 / 0.85, rel=1e-2)
    ramp = run_of(Scene('cells', 'ramp over 5 windows', True, 1, 12)).p
    place = int(np.ptp(ramp, axis=0).argmax())
    assert ramp[-1, place] / ramp[0, place] == pytest.approx(1.3, abs=1e-9) or ramp[
        -1, place
    ] / ramp[0, place] == pytest.approx(0.7, abs=1e-9)
    assert (np.diff(ramp[:, place]) != 0.0).sum() == pytest.approx(5 * 300, abs=2)


def test_one_sample_in_some_windows_is_far_off():
    quiet, spoiled = (run_of(Scene('cells', 'outliers', True, 2, 20)) for _ in range(2))
    assert 3 <= spoiled.spoiled.sum() <= 17
    windows = np.flatnonzero(spoiled.spoiled) // 300
    assert len(set(windows)) == spoiled.spoiled.sum()
    off = spoiled.y - np.array([quiet.x[:, i] for i in (0, 2, 5)]).T
    far = (np.abs(off) > 0.6 * OUTLIER * 0.1).any(axis=1)
    np.testing.assert_array_equal(far, spoiled.spoiled)


def test_noise_has_its_deviation_and_colour():
    for kind, correlation in (('white', 0.0), ('coloured', 0.5), ('t3', 0.0)):
        made = noise(np.random.default_rng(5), kind, (40_000, 1))[:, 0]
        assert made.std() == pytest.approx(1.0, abs=0.1 if kind == 't3' else 0.02)
        found = np.mean(made[1:] * made[:-1]) / made.var()
        assert found == pytest.approx(correlation, abs=0.02)


def test_what_a_model_leaves_out_is_the_share_that_is_said():
    x, p = (
        {
            'cells': ([50.0] * 6, [1.0, 1.0, 1.0, 0.1, 40.0, 40.0]),
            'Monod': ([3.0, 2.0], [0.5, 0.5, 0.5]),
            'compartments': ([2.0, 0.0, 0.0], [0.3, 0.5, 0.5, 0.2, 0.1]),
            'motor': ([5.0, 100.0], [1.0, 30.0, 0.1, 2.0, 1.0]),
            'van der Pol': ([2.0, 0.0], [0.5, 1.0, 1.0]),
        },
        {
            'cells': -0.1 * 30.0 / 40.0,
            'Monod': -0.5 * 2.0 / 2.5 * 3.0 / 2.0,
            'compartments': 0.3 * 2.0 / 2.0,
            'motor': -0.1 * 5.0 / 2e-3,
            'van der Pol': -2.0,
        },
    )
    for plant, (states, parameters) in x.items():
        extra = UNMODELLED[plant](states, parameters)
        place = 1 if plant in ('motor', 'van der Pol') else 0
        assert len(extra) == len(states)
        assert extra[place] == pytest.approx(p[plant]), plant


@pytest.mark.parametrize(
    ('jumps', 'how', 'late', 'mended', 'back'),
    [
        ([(3, said('inductance', 3.52))], How.RIGHT, False, False, False),
        ([(4, said('inductance', 3.52))], How.RIGHT, True, False, False),
        (
            [(3, said('inertia', 3.4, alternatives=('friction', 'inductance')))],
            How.LISTED, False, False, False,
        ),
        (
            [(3, said('inertia', 3.4)), (4, said('inductance', 3.5))],
            How.MISNAMED, False, True, False,
        ),
        (
            [(3, said('inductance inertia', 3.6)),
             (5, said('inductance inertia', 3.6, retracted=True))],
            How.MISNAMED, False, False, True,
        ),
        ([(3, said('inductance', 3.5, new=False))], How.MISSED, False, False, False),
        ([(2, said('inductance', 2.5))], How.MISSED, False, False, False),
        ([(6, said('inductance', 6.5))], How.MISSED, False, False, False),
    ],
)  # fmt: skip
def test_the_first_announcement_near_a_jump_decides_how_it_was_told(jumps, how, late, mended, back):
    (verdict,) = verdicts(made(*jumps, changes=(JUMP,)))
    assert verdict[:4] == (how, late, mended, back)
    assert verdict.until == WINDOWS
    assert verdict.window == (3 if how is How.MISSED else jumps[0][0])
    wrong = false_jumps(made(*jumps, changes=(JUMP,)))
    assert len(wrong) == sum(one.new and abs(one.time - 3.5) > 0.5 for _, one in jumps)


def test_the_windows_after_a_jump_end_with_the_next_one():
    later = Change(6.2, 0, 0.1)
    run = made((3, said('inductance', 3.5)), changes=(JUMP, later))
    np.testing.assert_array_equal(np.flatnonzero(after(run, [How.RIGHT])), [3, 4, 5])
    np.testing.assert_array_equal(np.flatnonzero(after(run, [How.MISSED])), [6, 7])
    np.testing.assert_array_equal(np.flatnonzero(calm(run)), [0, 1, 2])
    assert settled(run).all()
    late = made(changes=(Change(3.9, 1, 10.0),))
    np.testing.assert_array_equal(np.flatnonzero(~settled(late)), [3])
    pushed = scores.pushed([run], lambda run: after(run, [How.RIGHT]))
    assert (pushed.hits, pushed.count) == (1, 3)


def test_an_error_is_measured_by_the_side_of_the_interval_that_the_truth_is_on():
    run = made()
    run.error[0, 0], run.lower[0, 0], run.upper[0, 0] = 0.3, -0.1, 0.4  # the truth: .4 below it
    run.error[1, 0], run.lower[1, 0], run.upper[1, 0] = 0.3, 0.2, 2.0
    run.lower[2, 0] = run.upper[2, 0] = np.nan
    assert run.beyond[0, 0] == pytest.approx(0.75 * COVERED)
    assert run.beyond[1, 0] == pytest.approx(3.0 * COVERED)
    run.accepted[3] = False
    found = scores.coverage([run])
    assert (found.hits, found.count) == (7 * 7 - 2, 7 * 7 - 1)
    assert scores.beyond([run], 5.0).hits == 1
    assert scores.beyond([run], 6.0).hits == 0
    assert scores.count([run]) == 7


def test_a_jump_is_the_more_visible_the_more_was_measured_since():
    run = run_of(Scene('motor', 'jump', True, 2, WINDOWS))
    (change,) = run.changes
    found = visible(run)
    window = int(change.time)
    assert np.isinf(found[:window]).all()
    assert (np.diff(found[window:]) >= -1e-6 * found[-1]).all()
    # Of a jump too small to bend anything, it is as the square of the size.
    small, tenth = (
        visible(run._replace(changes=(change._replace(size=share * change.size),)))
        for share in (0.02, 0.002)
    )
    np.testing.assert_allclose(small[window:], 100.0 * tenth[window:], rtol=0.1)
    assert told(made()._replace(visible=np.arange(8.0) * 3.0)).tolist() == [False] * 4 + [True] * 4


def test_a_share_knows_that_a_runs_windows_hang_together():
    together = clustered([(20, 20), (0, 20)] * 10)
    apart = clustered([(10, 20)] * 20)
    assert together.value == apart.value == 0.5
    assert (apart.low, apart.high) == share_interval(200, 400)
    few = share_interval(10, 20)
    assert (together.low, together.high) == pytest.approx(few, abs=0.01)
    assert str(clustered([])) == '-'
    assert clustered([(0, 20)] * 20).high == share_interval(0, 400)[1]


def test_the_bootstrap_draws_runs():
    values = np.random.default_rng(3).normal(2.0, 1.0, 400)
    middle, low, high = resampled(lambda places: float(values[list(places)].mean()), 400)
    assert middle == pytest.approx(values.mean())
    assert high - low == pytest.approx(2.0 * COVERED / 20.0, rel=0.15)


def test_what_is_sharper_shows_as_such():
    rng = np.random.default_rng(9)
    theirs = [made()._replace(error=rng.normal(size=(WINDOWS, 7))) for _ in range(6)]
    ours = [
        run._replace(error=0.9 * run.error, lower=1.2 * run.lower, upper=1.2 * run.upper)
        for run in theirs
    ]
    found = scores.sharpness(ours, theirs)
    assert found.sd[0] == pytest.approx(1.2)
    assert found.rms == pytest.approx((0.9, 0.9, 0.9))
    doubted = made((3, said('inductance', 3.5, alternatives=('no jump',))))
    assert not scores.sure(doubted)[3]
    assert scores.sure(doubted).sum() == WINDOWS - 1


def test_the_acceptance_fails_where_jumps_are_announced_though_nothing_jumps():
    for jumps, met in (((), True), (((2, said('inertia', 2.5)),), False)):
        own = [made(*jumps) for _ in range(5)]
        rows = asked(Measured({Cell('motor', 'oscillating', True): own}, {}, ()))
        (row,) = (row for row in rows if row.asked.startswith('oscillating'))
        assert row.met is met


def test_a_run_is_solved_beside_its_truth():
    run = followed(Scene('motor', 'jump', True, 1, 5))
    assert run.error.shape == (5, 7)
    assert run.accepted.all()
    assert (run.beyond < 5.0).all()
    (verdict,) = verdicts(run)
    assert verdict.how is How.RIGHT
    assert verdict.time_error < 0.01


@pytest.mark.slow
def test_the_benchmark_reports_what_was_asked_beside_the_same_tree(tmp_path, monkeypatch):
    for name, value in (('PLANTS', ('motor',)), ('WINDOWS', 9)):
        monkeypatch.setattr(f'benchmarks.sequence.jumps_elsewhere.run.{name}', value)
    chosen = ['--only', 'jumps_elsewhere', '--runs', '1', '--against', str(ROOT)]
    text = main([*chosen, '--results', str(tmp_path)])
    assert text == (tmp_path / 'sequence_jumps_elsewhere.md').read_text()
    assert '| asked | measured | met |' in text
    assert '| motor | rich | clean | 9 | ' in text
    assert text.count('| rich | named right | ') == 2
    assert 'median sd <= 1.15 x that of the other tree | 1.000 (1.000-1.000)' in text
    assert 'RMS error <= 1.05 x that of the other tree | 1.000 (1.000-1.000)' in text
    assert '| time of a window with a jump <= 1.5 x that of the other tree | ' in text
