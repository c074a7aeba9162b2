"""The windows with process noise are those that their report describes."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.process_noise.__main__ import main
from benchmarks.process_noise.compiled import likelihood_of
from benchmarks.process_noise.plants import PLANTS
from benchmarks.process_noise.reference import most_likely
from benchmarks.process_noise.report import acceptance, error_ratios
from benchmarks.process_noise.run import Solved, Window, simulated, warm_seconds
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid


@pytest.mark.parametrize('name', PLANTS)
def test_a_walk_moves_the_end_and_the_same_seed_gives_the_same_window(name: str) -> None:
    plant = PLANTS[name]._replace(samples=40)
    still, p, _, x = simulated(plant, 0.0, 3)
    again, _, _, same = simulated(plant, 0.0, 3)
    moved, q, _, y = simulated(plant, 1.0, 3)
    np.testing.assert_array_equal(still.y, again.y)
    np.testing.assert_array_equal(x, same)
    np.testing.assert_array_equal(p, q)
    assert np.abs(y - x)[list(plant.walking)].min() > 1e-3
    assert moved.y.shape == still.y.shape


@pytest.mark.parametrize('name', ['lag', 'tanks'])
def test_the_simulation_and_the_likelihood_agree_with_the_model(name: str) -> None:
    """Up to steps and derivatives of their own."""
    plant = PLANTS[name]._replace(samples=60)
    record, p, x0, _ = simulated(plant, 0.0, 5)
    grid, walks = Grid.of(plant.model, record, np.array(plant.noise)), np.zeros(x0.size)
    y = kernels_for(plant.model).trajectories(grid, x0[:, None], p[:, None])[1][..., 0]
    left = record.y - y
    np.testing.assert_allclose(left.std(axis=0), plant.noise, rtol=0.3)
    walks[list(plant.walking)], noise = 0.05, np.array(plant.noise)
    size = np.array([v.upper - v.lower for v in plant.model.states])
    steps = int(grid.steps[0])
    found = likelihood_of(plant.model)(
        record.t, record.u, record.y, x0, p, walks, noise, size, steps
    )
    sizes = np.concatenate([walks, np.zeros(p.size)])
    expected = kernels_for(plant.model).filter(grid, x0, p, sizes, noise).neg2_log_likelihood
    assert found == pytest.approx(expected, abs=0.5)


def test_the_reference_finds_parameters_from_the_truth() -> None:
    plant = PLANTS['lag']
    errors = []
    for seed in range(6):
        record, p, x0, _ = simulated(plant, 0.02, seed)
        errors.append(most_likely(plant, record, x0, p, 0.02) - p)
    assert (np.abs(errors).max(axis=0) < [0.15, 0.8]).all()
    assert np.abs(errors).min() > 1e-6


def windows(
    errors: float, seconds: float = 0.1, walk: float = 0.1, warm: float = 0.1
) -> list[Window]:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(400):
        error = rng.standard_normal(2)
        one = Solved(errors * error, np.ones(2), rng.standard_normal(1), np.ones(1),
                     np.array([walk]), 'converged', seconds)  # fmt: skip
        modes = {'off': one._replace(seconds=0.1), 'auto': one}
        found.append(Window(modes, error, {'off': 0.1, 'auto': warm}))
    return found


def met(**changed: float) -> list[bool]:
    cells = {('spring', 0.1): windows(**{'errors': 1.0} | changed)}
    return [row.met for row in acceptance(cells)]


def test_intervals_walks_times_and_errors_are_judged() -> None:
    """Parameters, end state, walks, time cold and warm, errors, the mean of all."""
    assert met() == [True] * 7
    assert met(errors=2.0) == [False, True, True, True, True, False, False]
    assert met(errors=0.4) == [False, True, True, True, True, True, False]
    assert met(walk=0.12) == [True, True, False, True, True, True, True]
    assert met(seconds=0.31) == [True, True, True, False, True, True, True]
    assert met(warm=0.21) == [True, True, True, True, False, True, True]


def test_a_ratio_of_errors_has_an_interval() -> None:
    found, (low, high) = error_ratios(windows(errors=1.3))
    np.testing.assert_allclose([found, low, high], 1.3)


def test_a_warm_window_is_timed() -> None:
    plant = PLANTS['lag']
    assert 0.0 < warm_seconds(plant, simulated(plant, 0.0, 1)[0], 'off', 1) < 60.0


@pytest.mark.slow
def test_the_command_reports_every_cell(tmp_path: Path) -> None:
    plants = ['--plants', 'lag', 'tanks', '--windows', '2', '--referred', '1']
    text = main([*plants, '--results', str(tmp_path)])
    assert text.count('| auto |') == text.count('| off |') == 6
    assert text.count("x the reference's |") == 6
    assert (tmp_path / 'process_noise.md').read_text() == text
