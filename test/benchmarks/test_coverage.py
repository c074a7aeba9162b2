"""Coverage of published intervals: what is published, true profiles, shares, costs."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.coverage.__main__ import main
from benchmarks.coverage.cost import compared, ratio
from benchmarks.coverage.reference import DELTA, Profile, profile
from benchmarks.coverage.report import acceptance
from benchmarks.coverage.run import IN_RUN, Track, likelihood_of, noise_of, tracked
from benchmarks.coverage.scores import Share, coverage, far, matched, median_width
from benchmarks.intervals import published_interval
from benchmarks.pairs import Cost, Pair
from benchmarks.runner import ROOT
from benchmarks.zoo.experiments import EXPERIMENTS, run
from obs_ros import solve_window
from obs_ros.core.model import names

LAG = EXPERIMENTS['lag']


def made(error: float, sd: float, windows: int = 100, seed: int = 0) -> list[Track]:
    """Return windows of two parameters and a state, with errors of so many deviations."""
    rng, tracks = np.random.default_rng(seed), []
    for _ in range(windows):
        truth = rng.uniform(1.0, 2.0, (1, 3))
        off = error * rng.standard_normal((1, 3))
        lower, upper = (truth + off + side * 1.96 * sd for side in (-1.0, 1.0))
        deviations = np.full((1, 3), sd)
        tracks.append(
            Track(off, deviations, lower, upper, truth, 2, ('converged',), (0,), np.full(1, 7.0))
        )
    return tracks


def test_an_interval_is_the_published_one_or_else_that_of_the_deviation() -> None:
    plain: Any = SimpleNamespace(parameters={'k': 2.0}, state={'x': 1.0}, stddev={'k': 0.1})
    assert published_interval(plain, 'k') == pytest.approx((1.804, 2.196))
    told: Any = SimpleNamespace(interval={'k': (1.9, 2.5)}, **vars(plain))
    assert published_interval(told, 'k') == (1.9, 2.5)
    withheld: Any = SimpleNamespace(**vars(plain) | {'stddev': {'k': np.nan}})
    assert np.isnan(published_interval(withheld, 'k')).all()


@pytest.mark.parametrize('sequence', [False, True])
def test_windows_lie_beside_their_truth(sequence: bool) -> None:
    track = tracked('lag', True, sequence, 3)
    windows = IN_RUN if sequence else 1
    assert track.error.shape == track.lower.shape == (windows, 3)
    assert len(track.outcomes) == len(track.jumps) == windows
    assert np.abs(track.error).max() < 1.0
    drawn = run(LAG, 3, True, windows)
    np.testing.assert_array_equal(track.truth[-1], [*drawn.p, *drawn.x[-1]])
    found = solve_window(
        LAG.model, drawn.window(0, LAG.samples).record, noise=noise_of(LAG), seed=3
    )
    errors = [found.parameters['k'] - drawn.p[0], found.state['x'] - drawn.x[LAG.samples - 1, 0]]
    np.testing.assert_allclose(track.error[0, [0, 2]], errors, atol=1e-3)
    # Of 300 values.
    assert 200.0 < track.squares.min() <= track.squares.max() < 400.0


def test_a_true_profile_is_a_parabola_where_a_window_tells_much() -> None:
    drawn = run(LAG, 5, True)
    found = profile(LAG, drawn, 5)
    known = names(LAG.model.variables)
    likelihood = likelihood_of(LAG, drawn)
    truth = dict(zip(known, [*drawn.x[0], *drawn.p], strict=True))
    sd = np.sqrt(np.diag(likelihood.bound(truth, 1.0)))[1:]
    half = np.sqrt(DELTA) * sd
    np.testing.assert_allclose(found.ends[:, 1] - found.best, half, rtol=0.05)
    np.testing.assert_allclose(found.best - found.ends[:, 0], half, rtol=0.05)


def test_a_true_profile_is_open_where_a_bound_comes_first() -> None:
    experiment = EXPERIMENTS['exchanger']
    found = profile(experiment, run(experiment, 0, False), 0)
    assert np.isinf(found.ends[:2]).any()
    assert (found.ends[:, 0] < found.best).all()
    assert (found.best < found.ends[:, 1]).all()


def test_shares_know_that_the_values_of_a_cluster_hang_together() -> None:
    every = [np.array([hit]) for hit in [True] * 90 + [False] * 10]
    alike = [np.repeat(one, 10) for one in every]
    single, tenfold = Share.of(every), Share.of(alike)
    assert single.value == tenfold.value == pytest.approx(0.9)
    assert (single.low, single.high) == pytest.approx((0.826, 0.945), abs=0.002)
    assert (tenfold.low, tenfold.high) == pytest.approx((single.low, single.high), abs=0.002)
    assert Share.of([np.ones(10, dtype=bool)] * 40).low == pytest.approx(0.912, abs=0.001)
    assert np.isnan(Share.of([]).value)
    assert Share.of([]).meets(0.92, 0.98)
    assert not Share.of(alike * 4).meets(0.95, 0.98)


def test_values_that_are_withheld_do_not_count() -> None:
    tracks = made(1.0, 1.0)
    assert coverage(tracks, False).count == 200
    assert coverage(tracks, False).value == pytest.approx(0.95, abs=0.03)
    nan = np.full((1, 3), np.nan)
    silent = [track._replace(lower=nan, upper=nan, sd=nan) for track in tracks]
    assert coverage([*tracks, *silent], True).count == 100
    assert far([*made(0.0, 1.0), *silent], True).value == 0.0
    assert far(made(100.0, 1.0), True).value > 0.9


def test_published_intervals_lie_beside_true_profiles() -> None:
    track = made(0.0, 0.1, windows=1)[0]
    low, high = track.lower[0, :2], track.upper[0, :2]
    ends = np.column_stack([low - [0.0, 9.0], np.add(high, [0.0, np.inf])])
    pair = matched(LAG.model, track, Profile(ends, 0.5 * (low + high), 3.0))
    assert pair.given.all()
    assert pair.narrow.tolist() == [True, False]
    assert pair.bounded.tolist() == [True, False]
    assert pair.true_held.all()
    assert median_width([pair]) == pytest.approx(1.0)
    assert pair.excess == 4.0


def met(tracks: list[Track], width: float = 1.0, seconds: float = 1.0) -> list[bool]:
    cells = {('lag', rich, way): tracks for rich in (False, True) for way in (False, True)}
    profiles = []
    for track in tracks[:50]:
        ends = np.column_stack([track.truth[0, :2] - 0.1 / width, track.truth[0, :2] + 0.1 / width])
        profiles.append(Profile(ends, track.truth[0, :2], 7.0))
    pair = Pair(Cost(seconds, ('a',)), Cost(1.0, ('a',)))
    costs = {cell: [pair] * 5 for cell in cells}
    return [row.met for row in acceptance(cells, {'lag': profiles}, costs)]


def test_what_is_asked_is_judged() -> None:
    """Coverage pooled, by cell, far errors; twice; given, widths; times, bits."""
    good = made(0.1 / 1.96, 0.1 / 1.96, windows=400)
    assert met(good) == [True] * 12
    assert met(good, width=2.0)[6:8] == [True, False]
    assert met(good, seconds=2.0)[8:] == [False, True, True, True]
    assert met(good, seconds=5.0)[8:] == [False, False, True, True]
    narrow = made(0.3, 0.1 / 1.96, windows=400)
    assert met(narrow)[:6] == [False] * 6
    nan = np.full((1, 3), np.nan)
    silent = [track._replace(lower=nan, upper=nan) for track in good[:10]]
    assert met([*silent, *good[10:]])[6] is False


def test_trees_are_compared_in_turns_bit_by_bit() -> None:
    costs = compared(ROOT, ['lag'], 2, 0)
    assert sorted(costs) == [('lag', rich, way) for rich in (False, True) for way in (False, True)]
    for (_, _, way), pairs in costs.items():
        assert all(pair.same for pair in pairs)
        assert pairs[0].own.values != pairs[1].own.values
        assert len(pairs[0].own.values) == (6 if way else 3)
        middle, low, high = ratio(pairs)
        assert low <= middle <= high
        assert 0.0 < low < high < 100.0


@pytest.mark.slow
def test_the_command_reports_every_cell(tmp_path: Path) -> None:
    plants = ['--plants', 'lag', 'Monod', '--windows', '10', '--referred', '2', '--timed', '1']
    text = main([*plants, '--against', str(ROOT), '--results', str(tmp_path)])
    # Every cell has its coverage and its cost; poor ones also their parameters.
    assert text.count('\n| lag, ') == text.count('\n| Monod, ') == 10
    assert text.count('same to the last bit') == 2
    assert (tmp_path / 'coverage.md').read_text() == text
