"""Tests of obs_ros.horizon.fitting."""

from dataclasses import replace
from typing import Any

import numpy as np
from stiff_plants import measured, van_der_pol

from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.fitting import fitted, of_window, polished, reweighted
from obs_ros.horizon.integration_error import error_at, noise_of
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.prior import Posterior, Prior
from obs_ros.integration.step_trials import STEPPING
from obs_ros.optimization.acceptance import Acceptance
from obs_ros.optimization.result import Effort, Found

MODEL = van_der_pol(1.0)
T = 0.2 * np.arange(80)
U = np.empty((80, 0))
RECORD, NOISE = measured(MODEL, T, U, (2.0, 0.0), (1.2,), share=1e-3, by='DOP853')
SOLVER = Solver.of(MODEL, EstimationSettings(noise=NOISE, backend='numpy', process_noise='off'))
WINDOW = SOLVER.pose(RECORD, prior=Prior.box(SOLVER.unknowns), noise_known=True)
Z = SOLVER.unknowns.point({'x': 2.0, 'rate': 0.0, 'mu': 1.2})


def test_an_optimum_that_errs_is_found_anew_in_finer_steps() -> None:
    assert error_at(WINDOW.objective, Z, noise_of(WINDOW)) > 3.0
    window, found = SOLVER.fit(
        WINDOW, WINDOW.posterior, random_generator(1), Deadline(), None
    )  # fmt: skip
    assert error_at(window.objective, found.z, noise_of(window)) < 0.1
    assert window.objective.grid.steps.sum() > 1.5 * WINDOW.objective.grid.steps.sum()
    assert found.accepted is not None and found.cost < 130.0
    assert window.objective.counter is WINDOW.objective.counter


def test_costs_of_another_window_keep_their_kind_and_prior() -> None:
    other = replace(WINDOW, objective=replace(WINDOW.objective))
    posterior = of_window(WINDOW.posterior, other)
    assert isinstance(posterior, Posterior) and posterior.prior is WINDOW.prior
    assert posterior.objective is other.objective
    assert of_window(WINDOW.objective, other) is other.objective


def test_polishing_leads_to_the_optimum_nearby() -> None:
    rough = Found(Z + 0.01, np.inf, converged=False, accepted=Acceptance.LIKE_NOISE,
                  effort=Effort(1, 'round'))  # fmt: skip
    found = polished(WINDOW.posterior, rough, Deadline())
    assert found.converged and found.accepted is Acceptance.LIKE_NOISE
    assert np.abs(found.z - Z).max() < 0.005


def test_outputs_whose_noise_is_given_keep_their_weight() -> None:
    found = Found(Z, 1.0, converged=True, accepted=None, effort=Effort(1, 'round'))
    window, same = reweighted(WINDOW, found, np.array([False]), Deadline())
    assert window is WINDOW and same is found


def test_what_noise_does_not_explain_is_sought_once_more_in_finer_own_steps() -> None:
    """The second search goes on from the first; with a start, or by explicit steps, there is none.

    Neighbours are looked at first: all of these searches return the truth, which has none better.
    """
    model = replace(MODEL, integrator='rosenbrock')
    solver = Solver.of(model, EstimationSettings(noise=NOISE))
    window = solver.pose(RECORD, prior=Prior.box(solver.unknowns), noise_known=True)
    window = solver.integration.begun(window, Z, None)
    assert window.objective.grid.tolerance == STEPPING.loosest

    def sought(by: Solver, posed: Any, warm: Any, deadline: Deadline) -> list[float]:
        tolerances: list[float] = []

        def search(problem: Any, start: Any) -> Found:
            tolerances.append(problem.objective.grid.tolerance)
            return Found(Z, 9.0 / len(tolerances), converged=True, accepted=None,
                         effort=Effort(1, 'round'))  # fmt: skip

        posed = replace(posed, exact=True)
        fitted(posed, posed.posterior, search, by.integration, deadline, warm, squares=True)
        return tolerances

    assert sought(solver, window, None, Deadline()) == [STEPPING.loosest, STEPPING.smooth]
    assert sought(solver, window, None, Deadline(0.0)) == [STEPPING.loosest]  # no time is left
    assert sought(solver, window, Z, Deadline()) == [STEPPING.loosest]
    assert sought(SOLVER, WINDOW, None, Deadline()) == [0.0]


def test_the_grid_of_an_answer_by_own_steps_has_those_of_its_optimum() -> None:
    model = replace(MODEL, integrator='rosenbrock')
    solver = Solver.of(model, EstimationSettings(noise=NOISE))
    window = solver.pose(RECORD, prior=Prior.box(solver.unknowns), noise_known=True)
    window = solver.integration.begun(window, 0.9 * Z, None)
    found = Found(Z, 1.0, converged=True, accepted=Acceptance.LIKE_NOISE, effort=Effort(1, 'round'))
    window, same = fitted(
        window, window.posterior, lambda *_: found, solver.integration, Deadline(), None,
        squares=True,
    )  # fmt: skip
    objective = window.objective
    counts = objective.kernels.counts(objective.grid, *solver.unknowns.values(same.z[None]))
    np.testing.assert_array_equal(objective.grid.steps, counts[:, 0])
    assert error_at(objective, same.z, noise_of(window)) < 0.1
