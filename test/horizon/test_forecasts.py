"""Tests of obs_ros.horizon.forecasts."""

import numpy as np
import pytest
from plants import LAG, lag_outputs, square_wave

from obs_ros import Record
from obs_ros.core.typing import Array
from obs_ros.horizon.forecasts import FORECASTS, Basis, Ends, Forecasts
from obs_ros.integration.backends import kernels_for

DURATION, INTERVAL, SIGMA = 20.0, 0.1, 0.02
RIGHT, WRONG = np.array([1.2, 3.0]), np.array([0.6, 3.0])
T = INTERVAL * np.arange(2401)
U = square_wave(T)
Y = lag_outputs(T, U, 1.0, np.tile(RIGHT, (T.size, 1)))
KERNELS = kernels_for(LAG, 'numpy')


def record(first: float, last: float, seed: int = 0) -> Record:
    inside = (first - 1e-9 <= T) & (last + 1e-9 >= T)
    noise = SIGMA * np.random.default_rng(seed).standard_normal(T.size)
    u = U[inside]
    u[0] = square_wave(T)[inside][0]  # every record begins with a value
    return Record(T[inside], u, (Y + noise)[inside])


def ends(time: float, **bases: Array) -> dict[Basis, Ends]:
    x = Y[[round(time / INTERVAL)]]
    return {Basis[name]: Ends(x, p) for name, p in bases.items()}


def run(forecasts: Forecasts, period: float, windows: int, **bases: Array) -> list[Basis]:
    """Windows of 20 s, one every `period` s, each of which begins forecasts."""
    chosen = []
    for k in range(windows):
        first = k * period
        forecasts.advance(KERNELS, record(first, first + DURATION))
        end = first + DURATION
        held = Y[[round(end / INTERVAL)]]
        forecasts.begin(ends(end, **bases), end, DURATION, held, np.array([SIGMA]))
        chosen.append(forecasts.decide())
    return chosen


def test_the_skill_is_that_of_the_first_horizon() -> None:
    forecasts = Forecasts()
    run(forecasts, 5.0, 12, PROCESS_NOISE=RIGHT)
    skill = forecasts.skill()
    assert skill is not None and skill > 0.99
    wrong = Forecasts()
    run(wrong, 5.0, 12, PROCESS_NOISE=WRONG)
    found = wrong.skill()
    assert found is not None and found < 0.9


def test_inputs_with_samples_of_their_own_are_held_where_a_forecast_goes_on(monkeypatch) -> None:
    """Every window of a plant whose inputs had stamps of their own failed where it was pushed."""
    skills = []
    for sparse in (False, True):
        # Of a square wave every fifth sample tells as much; windows end between two of them.
        known = (np.arange(T.size) % 5 == 0) | (np.diff(U, prepend=0.0) != 0.0)
        if sparse:
            monkeypatch.setitem(globals(), 'U', np.where(known, U, np.nan))
        forecasts = Forecasts()
        run(forecasts, 5.2, 12, PROCESS_NOISE=RIGHT)
        skills.append(forecasts.skill())
    assert skills[0] == skills[1] is not None


def test_there_is_no_skill_before_forecasts_have_come_true() -> None:
    forecasts = Forecasts()
    run(forecasts, 5.0, FORECASTS.enough, PROCESS_NOISE=RIGHT)
    assert forecasts.skill() is None


def test_a_basis_that_forecasts_better_is_taken_after_some_windows_and_kept() -> None:
    forecasts = Forecasts()
    chosen = run(forecasts, 10.0, 20, PROCESS_NOISE=WRONG, FILTERED=WRONG, OUTPUT_ERROR=RIGHT)
    first = chosen.index(Basis.OUTPUT_ERROR)
    assert FORECASTS.enough <= first <= 10
    assert set(chosen[:first]) == {Basis.PROCESS_NOISE}
    assert set(chosen[first:]) == {Basis.OUTPUT_ERROR}


def test_bases_that_are_alike_do_not_change_places() -> None:
    near = RIGHT * 1.001
    chosen = run(Forecasts(), 10.0, 20, PROCESS_NOISE=near, FILTERED=RIGHT, OUTPUT_ERROR=RIGHT)
    assert set(chosen) == {Basis.PROCESS_NOISE}


def test_beyond_holding_the_last_value_all_are_alike() -> None:
    """Both are of no use, though one is a hundred times as far off."""
    bad, worse = np.array([-3.0, 3.0]), np.array([-300.0, 3.0])
    chosen = run(Forecasts(), 10.0, 20, PROCESS_NOISE=worse, FILTERED=bad, OUTPUT_ERROR=bad)
    assert set(chosen) == {Basis.PROCESS_NOISE}


def test_a_gap_that_no_window_covers_ends_the_forecasts_under_way() -> None:
    forecasts = Forecasts()
    for k in range(8):
        first = 30.0 * k
        forecasts.advance(KERNELS, record(first, first + DURATION))
        end = first + DURATION
        held = Y[[round(end / INTERVAL)]]
        forecasts.begin(ends(end, PROCESS_NOISE=RIGHT), end, DURATION, held, np.array([SIGMA]))
    assert forecasts.skill() is None


@pytest.mark.parametrize('period', [0.5, 5.0])
def test_forecasts_under_way_are_bounded_however_often_windows_close(period: float) -> None:
    forecasts = Forecasts()
    lanes = []
    trajectories = KERNELS.trajectories

    class Counting:
        model = LAG

        def trajectories(self, grid: object, x: Array, p: Array) -> tuple[Array, Array]:
            lanes.append(x.shape[1])
            return trajectories(grid, x, p)  # type: ignore[arg-type]

    for k in range(60 if period < 1.0 else 12):
        first = k * period
        forecasts.advance(Counting(), record(first, first + DURATION))  # type: ignore[arg-type]
        end = first + DURATION
        held = Y[[round(end / INTERVAL)]]
        forecasts.begin(ends(end, PROCESS_NOISE=RIGHT), end, DURATION, held, np.array([SIGMA]))
    assert max(lanes) <= len(Basis) * (FORECASTS.pending + 1)


def test_windows_that_abut_are_compared_too() -> None:
    """The first sample of one window comes an interval after the last one of the other."""
    forecasts = Forecasts()
    for k in range(10):
        first = DURATION * k + (INTERVAL if k else 0.0)
        forecasts.advance(KERNELS, record(first, DURATION * (k + 1)))
        end = DURATION * (k + 1)
        held = Y[[round(end / INTERVAL)]]
        forecasts.begin(ends(end, PROCESS_NOISE=RIGHT), end, DURATION, held, np.array([SIGMA]))
    skill = forecasts.skill()
    assert skill is not None and skill > 0.99


def test_inputs_after_the_last_output_wait_for_the_next_window() -> None:
    forecasts = Forecasts()
    for k in range(12):
        window = record(5.0 * k, 5.0 * k + DURATION + 0.5)
        y = window.y.copy()
        y[-5:] = np.nan
        forecasts.advance(KERNELS, window.with_outputs(y))
        end = 5.0 * k + DURATION
        held = Y[[round(end / INTERVAL)]]
        forecasts.begin(ends(end, PROCESS_NOISE=RIGHT), end, DURATION, held, np.array([SIGMA]))
    skill = forecasts.skill()
    assert skill is not None and skill > 0.99
