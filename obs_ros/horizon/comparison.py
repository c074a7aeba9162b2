"""A window beside those before it: forecasts of its models, and scatter of what windows publish."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.changes import replace
from obs_ros.horizon.bases import Bases, ends_of
from obs_ros.horizon.forecasts import Basis, Forecasts
from obs_ros.horizon.scatter import Alone, Scatter, raised, widened
from obs_ros.horizon.solution import Solution, plain_fits
from obs_ros.inference.assessment.skill import last_values, least_noises
from obs_ros.inference.assessment.uncertainty import Uncertainty
from obs_ros.inference.window_state import WindowState


def by_forecasts(forecasts: Forecasts, posed: WindowState, solution: Solution) -> Solution:
    """Return the solution that forecasts speak for, and begin those of this window."""
    if plain_fits(solution):
        return solution
    own, plain = solution.disturbed, solution.plain
    bases = None if own is None else Bases(posed, solution.still or plain, own)
    if bases is not None and not forecasts.begun:
        forecasts.basis = bases.by_cross_validation()
    grid = posed.objective.grid
    last = int(np.flatnonzero(grid.measured)[-1])
    forecasts.begin(
        {Basis.OUTPUT_ERROR: ends_of(plain)} if bases is None else bases.ends,
        float(grid.t[last]),
        posed.duration,
        last_values(grid, last),
        least_noises(grid),
    )
    basis = forecasts.decide()
    return solution if bases is None else solution.by(bases.window(basis))


def compared(
    uncertainty: Uncertainty, forecasts: Forecasts, scatter: Scatter, said: str
) -> Uncertainty:
    """Return the uncertainty by the forecasts so far and the scatter of windows, this one too.

    `said` tells in words what else was decided.
    """
    skill = forecasts.skill()
    if not uncertainty.walking:
        scatter.add(Alone.of(uncertainty, uncertainty.fit.enlargement))
    factors = scatter.factors()
    best = uncertainty.hypothesis
    places = best.final_parameters
    return replace(
        uncertainty,
        skill=uncertainty.skill if skill is None else skill,
        covariance=raised(uncertainty.covariance, places, factors),
        interval=widened(uncertainty.interval, factors),
        scatter=factors,
        said=said,
    )


def figures_of(uncertainty: Uncertainty) -> Mapping[str, float]:
    """Return figures for the diagnostics: forecast skill, scatter beside deviations."""
    figures = {}
    if uncertainty.skill is not None:
        figures['forecast_skill'] = uncertainty.skill
    if uncertainty.scatter is not None:
        unknowns = uncertainty.hypothesis.problem.objective.unknowns
        parameters = unknowns.names[unknowns.n_states :]
        for name, factor in zip(parameters, uncertainty.scatter, strict=True):
            if np.isfinite(factor):
                figures[f'scatter_over_sd.{name}'] = float(factor)
    return figures
