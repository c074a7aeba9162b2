import math

import numpy as np
import pytest
from extras import needs

from benchmarks.judge import Judge
from benchmarks.kernel.__main__ import main as measure_kernel
from benchmarks.kernel.run import gcc_version
from benchmarks.peers import run as peers
from benchmarks.peers.__main__ import main as measure_peers
from benchmarks.peers.problem import Oracle, Problem, Stopped
from benchmarks.peers.registry import OURS, PEERS, Peer
from benchmarks.report import requirements
from benchmarks.scaling.curve import Curve
from benchmarks.scaling.metered import spent
from benchmarks.search.__main__ import main as measure_search
from benchmarks.search.contest import KNOWN, Score, Verdict, contested, limited_name
from benchmarks.search.report import acceptance, believed
from benchmarks.tanks import PAPER_WINDOWS, paper_end, paper_levels, paper_window, random_window
from benchmarks.three_tank_tables.convergence import follow
from benchmarks.three_tank_tables.reference import FITNESSES, SNRS, SYMBOLS, Cell, references
from benchmarks.three_tank_tables.run import FIRST_SAMPLE, MEMETIC, PAPER, bounds, errors_of
from benchmarks.windows import run as windows
from benchmarks.zoo.tank_chain import tank_chain
from obs_ros import solve_window
from obs_ros.models.three_tank import FLOW, TANK_AREA, THREE_TANK


@pytest.mark.parametrize(
    ('window', 'levels'),
    [
        ('T1', [21.25897, 14.17197, 17.71669]),
        ('T2', [59.53719, 49.96477, 52.93330]),
        ('T3', [86.27335, 52.72873, 65.42825]),
    ],
)
def test_the_papers_windows_end_at_the_levels_that_radau_gives(window, levels):
    np.testing.assert_allclose(paper_end(window), levels, atol=1e-4)


def test_the_papers_h3_cannot_come_from_its_constants():
    assert paper_levels('T1')[:, 2].min() > 17.69


@pytest.mark.parametrize(
    ('window', 'expected'),
    [
        ('T1', [0.01303, 0.00120, 0.01204, 0.2491]),
        ('T2', [0.01679, 0.000385, 0.06294, 0.2822]),
        ('T3', [0.00896, 0.000465, 0.02005, 0.6690]),
    ],
)
def test_the_cramer_rao_bound_is_the_specifications(window, expected):
    np.testing.assert_allclose(bounds(window, 4), expected, rtol=0.02)


def test_the_reference_covers_every_cell_of_both_tables():
    assert set(references()) == {
        Cell(fitness, window, snr)
        for fitness in FITNESSES
        for window in PAPER_WINDOWS
        for snr in SNRS
    }
    reference = references()[Cell('ft1', 'T3', 40.0)]
    assert reference.p95.tolist() == [0.074, 0.0025, 0.13, 4.3]
    assert reference.run.tolist() == [3.8e-4, 0.0, 2.2e-3, 0.018]
    assert np.isnan(references()[Cell('ft2', 'T1', math.inf)].run).all()


@pytest.mark.parametrize('fitness', FITNESSES)
def test_paper_mode_is_as_good_as_the_reference(fitness):
    cell = Cell(fitness, 'T1', 40.0)
    errors = [errors_of(cell, PAPER, seed) for seed in range(5)]
    assert (np.median(errors, axis=0) <= references()[cell].p95).all()


def test_a_first_sample_taken_as_exact_spoils_h3():
    cell = Cell('ft1', 'T2', 0.0)
    h3 = {
        way: np.median([errors_of(cell, way, seed)[3] for seed in range(8)])
        for way in (PAPER, FIRST_SAMPLE)
    }
    assert h3[FIRST_SAMPLE] > 2.0 * h3[PAPER]


def test_the_judge_recovers_a_truth_without_noise_from_elsewhere():
    window = paper_window('T2', math.inf, 0)
    judge = Judge(THREE_TANK, window.record, SYMBOLS, window.truth)
    assert judge.squares(window.truth) < 1e-6
    elsewhere = {**window.truth, 'p1': 0.4, 'p3': 0.6, 'h3': 30.0}
    assert judge.squares(elsewhere) > 1e3
    assert judge.optimum(elsewhere, 0, seed=1) < 1e-6


def test_the_judges_derivatives_are_those_of_its_residuals():
    window = paper_window('T3', 20.0, 0)
    judge = Judge(THREE_TANK, window.record, SYMBOLS, window.truth)
    z, direction = judge.point(window.truth), np.array([0.3, -0.2, 0.5, 0.1])
    change = (judge.residuals(z + 1e-5 * direction) - judge.residuals(z - 1e-5 * direction)) / 2e-5
    np.testing.assert_allclose(judge.jacobian(z) @ direction, change, rtol=1e-3, atol=1e-3)


def test_the_judge_sees_a_search_that_stopped_short():
    window = random_window(7, 200, 20.0)
    estimate = solve_window('three_tank', window.record, seed=7)
    found = {**estimate.initial_state, **estimate.parameters}
    short = {**found, 'p2': found['p2'] - 0.01}
    verdict = windows.judged(7, 200, 20.0, 2, {'unknown': found, 'known': short})
    assert abs(verdict.excess['unknown']) <= windows.SOLVED
    assert verdict.excess['known'] > 10.0


def test_a_followed_search_reaches_the_optimum():
    window = paper_window('T3', 40.0, 1)
    run = follow(window, SYMBOLS, 'memetic', 'least_squares', 1)
    seen = run.excess[np.isfinite(run.excess)]
    assert seen.size < run.excess.size  # it began on a part of the window
    assert (seen[1:] <= seen[:-1]).all()
    assert seen[-1] < 0.41


def test_the_default_search_beats_paper_mode_where_noise_is_small():
    cell = Cell('ft1', 'T3', 40.0)
    paper, memetic = (
        np.median([errors_of(cell, way, seed) for seed in range(4)], axis=0)
        for way in (PAPER, MEMETIC)
    )
    assert (10.0 * memetic < paper).all()


def test_the_kernel_benchmark_compares_equal_work(tmp_path):
    rows = measure_kernel(['--samples', '100', '--rounds', '2', '--results', str(tmp_path)])
    assert [row.lanes for row in rows] == [1, 16, 32, 64]
    assert all(row.ours < row.numpy for row in rows)
    assert all(np.isfinite(row.ratio) == (gcc_version() is not None) for row in rows)
    assert 'ours / C' in (tmp_path / 'kernel.md').read_text()


def test_a_contest_tells_the_optimum_from_what_the_papers_search_finds():
    verdict = contested('three tanks 50, 20 dB', 70_000, 1, 2)
    assert verdict.judge_excess <= 0.1
    for way in ('memetic', KNOWN, 'DE + LM', 'scipy, 1 start', limited_name('memetic', 0.1)):
        assert verdict.scores[way].solved, way
        assert verdict.scores[way].accepted, way
    assert not verdict.scores['paper mode'].solved
    assert 0.0 < verdict.scores['memetic'].seconds < 0.1


def test_a_window_off_the_optimum_that_was_believed_is_a_false_accept():
    right = Score(0.5, 0.01, True, True)
    wrong, doubted = Score(1.5, 0.01, True, False), Score(2.0, 0.01, False, False)
    verdicts = [Verdict({'memetic': score}, 0.0) for score in (right, wrong, doubted)]
    assert believed(verdicts, 'memetic') == (2, 1)


@pytest.mark.slow
def test_the_search_benchmark_reports_what_it_accepts(tmp_path):
    arguments = ['--windows', '1', '--cases', 'three tanks 50, 20 dB', '--results', str(tmp_path)]
    text = measure_search(arguments)
    assert text == (tmp_path / 'search.md').read_text()
    assert '| those cells together >= 99.5 % | 100.0 % | yes |' in text
    assert (tmp_path / 'search_success.png').stat().st_size > 10_000


def test_acceptance_fails_where_windows_are_missed():
    score = Score(0.0, 0.01, True, True)
    missed = score._replace(excess=3.0)
    ways = ('memetic', KNOWN, 'memetic, safe', limited_name('memetic', 0.02))
    own = [Verdict(dict.fromkeys(ways, one), 0.0) for one in (score, score, missed)]
    told = requirements(acceptance({'Lorenz 5': own, 'Lorenz 10': own}, []))
    assert 'Lorenz 5 67 % | **no** |' in told
    assert '| Lorenz 10 >= 88 % | 67 % | **no** |' in told
    assert '2 of 6: 33.33 % | **no** |' in told


@pytest.mark.parametrize('n', [2, 5, 8])
def test_a_row_of_tanks_keeps_what_flows(n):
    model = tank_chain(n)
    rng = np.random.default_rng(n)
    x, p = rng.uniform(5.0, 95.0, n), rng.uniform(0.2, 1.0, n)
    heads = x - np.append(x[1:], 0.0)
    flows = p * FLOW * np.sign(heads) * np.sqrt(2.0 * 981.0 * np.abs(heads))
    fed = np.append(30.0 / TANK_AREA, flows[:-1])
    np.testing.assert_allclose(model.dynamics(0.0, x, [30.0], p), fed - flows)
    assert model.output(0.0, x, [30.0], p) == tuple(x[::2])
    assert len(model.variables) == 2 * n


def test_a_metered_solve_counts_the_candidates_that_the_estimate_reports():
    run = spent(THREE_TANK, random_window(3, 60, 20.0).record, 3)
    assert run.estimate.outcome == 'converged'
    # A short window is rolled out as a whole, by every candidate: 59 steps each.
    assert run.steps == 59 * run.estimate.evaluations
    assert 0.0 < run.rest < 1.0


def test_growth_is_fitted_over_all_and_over_the_upper_half():
    x = [1.0, 10.0, 100.0, 1000.0]
    assert Curve('', '', x, [1.0, 1.0, 1.0, 100.0], (), (), '').exponents == pytest.approx((0.6, 2))


SHORT = 'three tanks 50, 20 dB'
# Within a second or two of process time; the others are given a moment, and must stop.
SURE = {
    OURS,
    'obs_ros, noise given',
    'scipy least_squares, restarts',
    'pygmo de',
    'pygmo sade',
    'pygmo de1220',
    'pycma',
}


@pytest.fixture(scope='module')
def short_window():
    return SHORT, 3, peers.judged(SHORT, 3, 2)


@pytest.mark.parametrize('name', PEERS)
def test_a_peer_solves_a_short_window_or_stops_in_time(name, short_window):
    needs(PEERS[name].package, 'test-peers')
    cap = 10.0 if name in SURE else 0.3
    found = peers.measured(name, *short_window, cap)
    assert np.isfinite([found.parameter_error, found.state_error]).all()
    if PEERS[name].filters:
        assert np.isnan(found.excess)
        return
    assert found.reached == (found.excess <= 0.615)
    assert found.excess > -0.1
    assert found.reached or name not in SURE


def test_the_oracle_stops_at_the_target_and_when_the_time_is_over():
    problem = Problem.of(SHORT, 3)
    z = (problem.truth - problem.objective.unknowns.scale.lower) / problem.width
    cost = float(problem.objective.costs(z[None])[0])
    below = Oracle(problem, cost - 1.0, 60.0)
    assert below.costs(z[None]) == pytest.approx(cost)
    assert not below.reached
    with pytest.raises(Stopped):
        Oracle(problem, cost + 1.0, 60.0).costs(z[None])
    with pytest.raises(Stopped):
        Oracle(problem, cost - 1.0, 0.0).costs(z[None])


def test_the_truth_at_a_windows_end_is_where_the_true_start_leads():
    problem = Problem.of('Lorenz 5', 3)
    z = (problem.truth - problem.objective.unknowns.scale.lower) / problem.width
    found = problem.at_end(z)
    np.testing.assert_allclose(found.state, problem.end, atol=1e-2)
    np.testing.assert_allclose(found.parameters, problem.truth[3:])


@pytest.mark.slow
def test_the_peers_report_names_who_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(PEERS, 'absent', Peer('absent', 'no_such_package', 'absent:prepare'))
    quick = ['absent', 'scipy least_squares, 1 start, batched']
    where = ['--results', str(tmp_path), '--windows', '1', '--cases', peers.CASES[0]]
    found = measure_peers([*where, '--peers', *quick])
    assert {one.peer for one in found} == {OURS, quick[1]}
    assert all(one.reached for one in found)
    assert 'absent: skipped, no_such_package is not installed' in capsys.readouterr().out
    assert 'skipped: absent' in (tmp_path / 'peers.md').read_text()
