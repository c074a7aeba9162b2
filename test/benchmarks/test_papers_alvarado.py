"""The audit of Alvarado-Méndez et al. 2024 on made-up runs: what is missed fails."""

import re
from collections.abc import Mapping

import numpy as np
import pytest

from benchmarks.papers.alvarado import claims as told
from benchmarks.papers.alvarado import report as tables
from benchmarks.papers.alvarado import theory_claims as theory
from benchmarks.papers.alvarado.paper import PAPER as FRAME
from benchmarks.papers.alvarado.printed import (
    GAMMA,
    MAGNITUDES,
    PAPERS_START,
    RIGHT_START,
    Printed,
    hidden_in_psi,
    least_freedom,
    lipschitz,
    printed_observer,
    row_with_signs,
    sign_choices,
    slowest_pole,
)
from benchmarks.papers.alvarado.roads import (
    CASES,
    COSINE,
    LONG,
    SOFTENING,
    TRAPEZOID,
    Truth,
)
from benchmarks.papers.alvarado.run import (
    CONTESTANTS,
    DESIGNED,
    NO_GAIN,
    PAPER,
    PRINTED,
    SCALE,
    WINDOWS,
    Figures,
    Measured,
    Window,
    percent,
    seeds_for,
)
from benchmarks.papers.claims import Claim, Verdict
from obs_ros import Outcome, load_observer
from obs_ros.models.suspension import KT, MUS, SUSPENSION
from obs_ros.observers.papers.adaptive_gains import stored_gains

SURE = Window(12.0, 0.01, 0.01 * KT, Outcome.CONVERGED)
SILENT = Window(12.0, 0.5, np.nan, Outcome.NOT_IDENTIFIABLE)
WRONG = Window(12.0, 0.5, 0.01 * KT, Outcome.CONVERGED)
KNOWN = {
    NO_GAIN: np.array([[2.57, 0.035, 2.55], [3.0, 0.1, 3.0]]),
    PRINTED: np.array([[2.25, 0.049, 2.3], [3.0, 0.1, 3.0]]),
    DESIGNED: np.array([[0.76, 0.187, 0.7], [3.0, 0.4, 3.0]]),
}


def figures_of(
    rms: float, near: float, *windows: Window, kept: bool = True, known: Mapping = KNOWN
) -> Figures:
    """Runs that are all alike, but for one of each that is better."""
    found = Measured(rms, 300.0, near, kept, True, windows)
    runs = {
        (one.label, case.label): [found, found._replace(rms=0.1, kept=True)]
        for one in CONTESTANTS
        for case in CASES
    }
    return Figures(2, runs, known, {}, {}, {}, [0.5, 0.2, 0.9, 2.0], 1)


def acceptance(rms: float, near: float, *windows: Window) -> list[bool]:
    return [one.met for one in tables.acceptance(figures_of(rms, near, *windows))]


@pytest.mark.parametrize(('rms', 'near', 'missed'), [(2.0, 0.3, 0), (3.0, 0.3, 2), (5.0, 1.2, 7)])
def test_acceptance_of_the_tyre_fails_what_is_missed(rms: float, near: float, missed: int) -> None:
    met = acceptance(rms, near, SURE)
    assert met.count(False) == missed
    assert met.count(True) == 18 - missed


def test_windows_on_the_cosine_may_be_off_if_they_withhold() -> None:
    assert acceptance(9.0, 0.3, SILENT).count(False) == 5
    # Off and confident: both rows of the cosine, and all six about confidence.
    assert acceptance(9.0, 0.3, WRONG).count(False) == 13
    assert WRONG.confidently_wrong
    assert not SURE.confidently_wrong and not SILENT.confidently_wrong


def verdicts(rows: list[Claim]) -> list[Verdict]:
    return [row.verdict for row in rows]


def test_a_gain_attenuates_where_its_error_is_below_that_without() -> None:
    rows = told.attenuation(figures_of(1.0, 0.1, SURE))
    assert verdicts(rows) == [Verdict.HOLDS, Verdict.DOES_NOT_HOLD, Verdict.HOLDS]
    assert rows[0].figure == '2.250, with L = 0 2.570' and rows[0].ours == '0.760'


def test_kt_is_found_where_few_runs_lose_it() -> None:
    figures = figures_of(1.0, 0.1, SURE)
    runs = figures.runs[PAPER.label, TRAPEZOID.label]
    assert told.despite_disturbance(figures).verdict is Verdict.NOT_SHOWN  # too few to tell
    runs[:] = runs[:1] * 200
    assert told.despite_disturbance(figures).verdict is Verdict.HOLDS
    runs[:10] = [run._replace(kept=False) for run in runs[:10]]
    row = told.despite_disturbance(figures)
    assert row.verdict is Verdict.NOT_SHOWN and row.figure.startswith('190 of 200 (')
    runs[:30] = [run._replace(kept=False) for run in runs[:30]]
    assert told.despite_disturbance(figures).verdict is Verdict.DOES_NOT_HOLD


def test_a_softer_tyre_is_monitored_where_kt_is_near_again() -> None:
    assert told.deterioration(figures_of(9.0, 0.1, SURE)).verdict is Verdict.HOLDS
    lost = figures_of(11.0, 0.1, SURE)
    assert told.deterioration(lost).verdict is Verdict.NOT_SHOWN  # one of two is near
    runs = lost.runs[PAPER.label, SOFTENING.label]
    runs[:] = runs[:1] * 10
    assert told.deterioration(lost).verdict is Verdict.DOES_NOT_HOLD


@pytest.mark.parametrize(
    ('kt', 'verdict'), [(0.95, Verdict.HOLDS), (0.5, Verdict.DOES_NOT_HOLD),
                        (7.2, Verdict.DOES_NOT_HOLD), (np.nan, Verdict.DOES_NOT_HOLD)]
)  # fmt: skip
def test_the_printed_equations_are_judged_by_where_kt_ends(
    monkeypatch, kt: float, verdict: Verdict
) -> None:
    truth = drive(LONG)
    monkeypatch.setattr(told, 'truth_of', lambda *_: truth)
    run = Printed(truth.x, np.full(truth.t.size, kt * KT))
    scales, starts = (1.0, SCALE), (RIGHT_START, PAPERS_START)
    found = {(scale, x0): run for scale in scales for x0 in starts}
    figures = figures_of(1.0, 0.1, SURE)._replace(found=found)
    assert told.start(figures).verdict is verdict
    run.kt[0] = 0.5 * KT  # how far it moves is told, and does not matter
    assert told.as_printed(figures).verdict is verdict


@pytest.mark.parametrize(
    ('ends', 'verdict'), [((0.5, 7.2), Verdict.DOES_NOT_HOLD), ((0.5, 1.005), Verdict.HOLDS),
                          ((np.nan, 0.98), Verdict.DOES_NOT_HOLD)]
)  # fmt: skip
def test_convergence_is_judged_by_where_the_paper_s_start_ends(ends, verdict: Verdict) -> None:
    x = np.zeros((2, 4))
    calm = {
        (scale, start): Printed(x, np.array([0.5, end if start == PAPERS_START else 1.0]) * KT)
        for scale, end in zip((1.0, SCALE), ends, strict=True)
        for start in (RIGHT_START, PAPERS_START)
    }
    row = told.without_disturbance(figures_of(1.0, 0.1, SURE)._replace(calm=calm))
    assert row.verdict is verdict and 'states off by at most 1e-09' in row.figure


def test_speeds_are_judged_by_their_own_size() -> None:
    speeds = {NO_GAIN: [2.0, 3.0], PRINTED: [5.9, 5.0], DESIGNED: [18.0, 9.5]}
    figures = figures_of(1.0, 0.1, SURE)._replace(
        speeds={name: np.array(own) for name, own in speeds.items()}
    )
    row = told.speeds(figures)
    assert row.verdict is Verdict.HOLDS and row.figure == '5.9 / 5.0, with L = 0 2.0 / 3.0'
    figures.speeds[PRINTED][1] = 10.1
    assert told.speeds(figures).verdict is Verdict.DOES_NOT_HOLD


def test_an_observer_with_constant_gains_has_no_covariances() -> None:
    assert (theory.equations(), theory.kalman_equations(1)) == (5, 5 + 15)
    assert theory.effort().verdict is Verdict.HOLDS


def test_a_disturbance_that_is_not_estimated_is_off_by_all_of_it() -> None:
    row = told.disturbance(figures_of(1.0, 0.1, SURE))
    assert row.verdict == Verdict.DOES_NOT_HOLD and row.figure.startswith('300 ')


def test_every_table_of_the_report_is_filled() -> None:
    text = tables.report(figures_of(1.0, 0.1, SURE))
    assert sum(line.startswith('| ---') for line in text.splitlines()) == 7
    assert '{' not in text
    assert not [quote for quote in FRAME.quotes if not re.search(quote.measured, text, re.M)]


def test_the_equations_alone_refute_what_they_do() -> None:
    assert not any('|' in str(cell) for row in theory.theory() for cell in row)  # of a table
    assert verdicts(theory.theory()) == [Verdict.DOES_NOT_HOLD] * 3
    assert least_freedom() == 0.0
    assert lipschitz() == (pytest.approx(KT / MUS), pytest.approx(1.0 / MUS))
    assert hidden_in_psi() == pytest.approx(37.8 / np.hypot(37.8, 22.15), rel=1e-6)


def test_the_lost_signs_leave_four_stable_choices() -> None:
    """Of which the fastest is stored; the third number of each row tells the signs within it."""
    choices = sign_choices()
    stable = [one for one in choices if one.stable]
    assert (len(stable), len(choices)) == (4, 16)
    fastest = min(stable, key=lambda one: one.pole)
    np.testing.assert_array_equal(fastest.L, stored_gains(SUSPENSION, 'printed').L)
    assert slowest_pole(MAGNITUDES) < 0.0
    with pytest.raises(ValueError, match='none is the difference of the rest'):
        row_with_signs(np.array([1.0, 2.0, 3.1]))


def drive(seconds: float, force: float = 0.0) -> Truth:
    """Standing still at the origin, but for outputs that are off by `force` as a length in m."""
    t = np.arange(round(seconds * 1e3)) * 1e-3
    u = np.tile([0.01, 2.0], (t.size, 1))
    return Truth(t, u, np.full((t.size, 3), force), np.zeros((t.size, 4)), 0.0 * t, 0.0 * t)


def test_the_printed_observer_takes_the_printed_steps() -> None:
    """One Euler step by hand, from xhat = 0.1: zd = vd = 0, so the damper is at rest."""
    L, H = stored_gains(SUSPENSION, 'printed').L, stored_gains(SUSPENSION, 'printed').H[0]
    run = printed_observer(drive(0.002), L, H, start=0.1, kt=KT, scale=1e5)
    e, phi = np.array([-0.1, -0.1, 0.0]), (0.01 - 0.1) / MUS
    rates = np.array([0.1, 0.0, 0.1, phi * KT])
    np.testing.assert_allclose(run.x[1], 0.1 + 1e-3 * (rates + L @ e), rtol=1e-12)
    assert run.kt[1] == pytest.approx(KT + 1e-3 * GAMMA * 1e10 * phi * H @ e)
    still = printed_observer(drive(0.002), L, H, start=0.1, kt=KT, scale=1e5, adapts=False)
    assert (still.kt == KT).all()


def test_what_is_lost_is_not_a_number() -> None:
    run = printed_observer(drive(0.5), -1e5 * np.ones((4, 3)), np.zeros(3), start=0.1, kt=KT,
                           scale=1.0)  # fmt: skip
    assert isinstance(run, Printed) and np.isnan(run.x[-1]).all()
    assert percent(run.kt / KT - 1.0) == np.inf


def test_contestants_share_their_noise_and_roads_do_not() -> None:
    rated, few = (seeds_for(one, TRAPEZOID, 40) for one in (PAPER, CONTESTANTS[2]))
    assert len(rated) == 40 and few == rated[:2]
    assert seeds_for(WINDOWS, TRAPEZOID, 40) == rated
    assert len(seeds_for(PAPER, SOFTENING, 40)) == 2
    assert not set(rated) & set(seeds_for(PAPER, COSINE, 40))


def test_every_contestant_is_an_observer_with_settings_that_it_takes() -> None:
    for one in CONTESTANTS:
        load_observer(one.observer)('suspension', **one.settings)
