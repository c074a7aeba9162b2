"""The front door: the states and parameters that explain one window of measurements best.

Of a plant x' = f(t, x, u, p), y = h(t, x, u, p) + e (or x_(k+1) = f(t, x, u, p), where the model
is discrete) the initial state and parameters z are sought that minimise the squares of the
residuals in units of the noise, sum_ki e_ki^2 / s_i^2: full information estimation over one window
(Rawlings, Mayne & Diehl 2017, section 4.2), solved by a global search (Yang, Li & Dahhou 2020,
section 4) and finished by Levenberg-Marquardt.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.core.record import Record
from obs_ros.core.rng import random_generator
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.objective import Fitness, Loss
from obs_ros.inference.process_noise import ProcessNoiseMode
from obs_ros.integration.backends import Backend
from obs_ros.models import load_model
from obs_ros.optimization.methods import Method
from obs_ros.samples.at_nodes import at_nodes
from obs_ros.samples.delay_line import at_own_times


def solve_window(
    model: Model | str,
    record: Record,
    search: str | Method = 'memetic',
    *,
    seed: int = 0,
    deadline: float | None = None,
    parameters: Iterable[str] | None = None,
    states: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    noise: Mapping[str, float] | None = None,
    previous: Estimate | None = None,
    initial: Mapping[str, float] | None = None,
    fitness: Fitness = 'least_squares',
    search_options: Mapping[str, Any] | None = None,
    backend: Backend | None = None,
    process_noise: ProcessNoiseMode = 'auto',
    loss: Loss = 'robust',
    walks: Mapping[str, float] | None = None,
    priors: Mapping[str, tuple[float, float] | None] | None = None,
) -> Estimate:
    """Estimate initial states and parameters of a plant from one record.

    Parameters
    ----------
    model : a Model, a built-in model's name, or `module:ATTRIBUTE`.
    record : times (K,), inputs (K, m) and outputs (K, r); NaN = not measured. By known delays
        each sample goes to its own time first; outputs before all inputs are known are left out.
        Outputs between the nodes of a discrete model do not count, which the message tells.
    search, and all that is not listed here : see `EstimationSettings`.
    seed : of everything random; without a deadline, the same seed gives the same bits.
    deadline : s until the best so far is returned, from when the model is compiled; None takes
        the time it needs.
    previous : the estimate of an earlier window, raced against fresh candidates.

    Raises ValueError for anything wrong with these, with the name and the value.
    """
    settings = EstimationSettings(
        search=search,
        search_options=search_options,
        parameters=parameters,
        states=states,
        fixed=fixed,
        bounds=bounds,
        noise=noise,
        initial=initial or {},
        fitness=fitness,
        backend=backend,
        process_noise=process_noise,
        loss=loss,
        walks=walks,
        priors=priors,
    )
    solver = Solver.of(load_model(model), settings)
    rng = random_generator(seed)
    record, off = at_nodes(solver.model, at_own_times(solver.model, record))
    estimate = solver.solve(record, rng, Deadline(deadline), previous)
    return replace(estimate, message=f'{estimate.message}; {off}') if off else estimate
