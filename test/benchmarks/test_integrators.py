"""The reference of the integrators' benchmark, its plants, and how it judges."""

import numpy as np
import pytest

from benchmarks.integrators import kinks, report, run
from benchmarks.integrators.plants import PLANTS
from benchmarks.integrators.reference import Reference, outputs


@pytest.mark.parametrize('name', ['motor, L/R .1 ms', 'van der Pol 10', 'enzyme', 'battery'])
def test_the_reference_agrees_with_another_method_in_finer_steps(name: str) -> None:
    plant = PLANTS[name]
    window = run.drawn(plant, plant.model, 3)
    n, record = len(plant.model.states), window.record
    given = plant.model, record.t, record.u, window.truth[:n], window.truth[n:]
    off = outputs(*given) - outputs(*given, method='Radau', rtol=1e-9)
    assert np.abs(off / window.noise).max() < 0.01


@pytest.mark.parametrize('name', PLANTS)
def test_windows_are_as_large_for_the_mild_plant_and_the_same_by_seed(name: str) -> None:
    plant = PLANTS[name]
    first, again = (run.drawn(plant, plant.model, 5) for _ in range(2))
    assert np.array_equal(first.record.y, again.record.y)
    assert np.isfinite(first.record.y).all()
    stiff, mild = plant.model, plant.mild
    assert [v.name for v in stiff.variables] == [v.name for v in mild.variables]
    assert [v.name for v in stiff.outputs] == [v.name for v in mild.outputs]
    assert np.isinf(stiff.max_step), 'a user gives none'


def test_points_and_values_are_each_others_inverse() -> None:
    plant = PLANTS['Robertson, even']
    window = run.drawn(plant, plant.model, 1)
    reference = Reference(plant.model, window.record, window.noise)
    back = reference.values(reference.point(window.truth))
    np.testing.assert_allclose(back, window.truth, rtol=1e-12)


def test_the_optimum_is_below_the_truth_by_about_the_unknowns() -> None:
    plant = PLANTS['motor, L/R 1 ms']
    window = run.drawn(plant, plant.model, 2)
    reference = Reference(plant.model, window.record, window.noise)
    gain = reference.squares(window.truth) - reference.optimum(window.truth)
    assert 0.0 < gain < 20.0  # chi-square with 5 degrees of freedom: 20 in 1 of 800


def test_levels_of_kinked_windows_cross() -> None:
    record, truth = kinks.crossing(7)
    assert record.y.shape == (kinks.SAMPLES, 2)
    assert ((truth[3:] >= 0.2) & (truth[3:] <= 1.0)).all()


def _solved(excess: float, error: float, seconds: float = 1.0) -> run.Solved:
    return run.Solved('motor', 'converged', excess, 0.5, error, 0.0, seconds, 1.0)


def test_rows_are_judged_by_their_limits() -> None:
    good = {'motor': [_solved(0.1, 0.05)] * 50}
    assert all(row.met for row in report.rows(good, [], [], {}))
    wrong = {'motor': [_solved(0.1, 0.05)] * 48 + [_solved(9.0, 0.4)] * 2}
    assert [row.met for row in report.rows(wrong, [], [], {})] == [False, True, False]
    slow = {'motor': [_solved(0.1, 0.05, seconds=11.0)] * 50}
    assert [row.met for row in report.rows(slow, [], [], {})] == [True, False, True]
    assert 'window 48' in report.failures(wrong)
    assert 'window 47' not in report.failures(wrong)
