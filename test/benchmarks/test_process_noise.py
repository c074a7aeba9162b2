"""The windows with process noise are those that their report describes."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.process_noise.__main__ import main
from benchmarks.process_noise.report import acceptance
from benchmarks.process_noise.run import PLANTS, Solved, simulated


@pytest.mark.parametrize('name', PLANTS)
def test_a_walk_moves_the_end_and_the_same_seed_gives_the_same_window(name: str) -> None:
    plant = PLANTS[name]._replace(samples=40)
    still, p, x = simulated(plant, 0.0, 3)
    again, _, same = simulated(plant, 0.0, 3)
    moved, q, y = simulated(plant, 1.0, 3)
    np.testing.assert_array_equal(still.y, again.y)
    np.testing.assert_array_equal(x, same)
    np.testing.assert_array_equal(p, q)
    assert np.abs(y - x)[list(plant.walking)].min() > 1e-3
    assert moved.y.shape == still.y.shape


def windows(errors: float) -> list[Solved]:
    rng = np.random.default_rng(1)
    return [
        Solved(errors * rng.standard_normal(2), np.ones(2), rng.standard_normal(1), np.ones(1),
               'converged', 0.1)
        for _ in range(400)
    ]  # fmt: skip


def test_intervals_that_are_too_short_are_not_met() -> None:
    for errors, met in ((1.0, True), (2.0, False), (0.4, False)):
        rows = list(acceptance({('a', 0.1, 'auto'): windows(errors), ('a', 0.1, 'off'): []}))
        assert [row.met for row in rows] == [met, True]


@pytest.mark.slow
def test_the_command_reports_every_cell(tmp_path: Path) -> None:
    text = main(['--windows', '2', '--results', str(tmp_path)])
    assert text.count('| auto |') == text.count('| off |') == 6
    assert (tmp_path / 'process_noise.md').read_text() == text
