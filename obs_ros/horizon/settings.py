"""Settings of an estimation that are the same from window to window."""

import logging
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from obs_ros.core.model import Model
from obs_ros.core.registry import suggest
from obs_ros.inference.objective import FITNESSES, LOSSES, Fitness, Loss
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.process_noise import MODES, ProcessNoiseMode
from obs_ros.integration.backends import Backend
from obs_ros.integration.delayed import delay_names
from obs_ros.optimization.methods import Method

log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class EstimationSettings:
    """Choices of the user about an estimation; `Solver.of` checks them against the model.

    - `search`: `memetic`, `chaotic_de`, `ga`, or a Method of your own; `search_options` replaces
      some of its settings.
    - `parameters`, `states`: names to estimate; None takes all parameters and initial states that
      are not fixed.
    - `fixed`: values of names that are not estimated; their default is the nominal value.
    - `bounds`: (lower, upper) by name, instead of the model's.
    - `noise`: standard deviation by output, in its unit; those not given come from the residual.
    - `initial`: values by name of a start that is raced against fresh candidates where there is no
      previous estimate; those not given start in the middle of their boxes.
    - `fitness`: `least_squares`, `euclidean` or `correlation`; the last two not for `memetic`.
    - `backend`: `numba` or `numpy`; None takes Numba where it is installed.
    - `process_noise`: `auto` tries it where the model alone does not explain a window, `off` never,
      `given` takes the walks of the states as they are.
    - `loss`: `robust` leaves outliers and bursts out, `squares` none; in least squares only.
    - `walks`: by name, in place of the model's; 0 takes the model's away.
    - `priors`: (mean, standard deviation) by name, in place of the model's; None takes the model's
      away. Those of states count in the first window; all of them in least squares only.
    """

    search: str | Method = 'memetic'
    search_options: Mapping[str, Any] | None = None
    parameters: Iterable[str] | None = None
    states: Iterable[str] | None = None
    fixed: Mapping[str, float] | None = None
    bounds: Mapping[str, tuple[float, float]] | None = None
    noise: Mapping[str, float] | None = None
    initial: Mapping[str, float] = field(default_factory=dict)
    fitness: Fitness = 'least_squares'
    backend: Backend | None = None
    process_noise: ProcessNoiseMode = 'auto'
    loss: Loss = 'robust'
    walks: Mapping[str, float] | None = None
    priors: Mapping[str, tuple[float, float] | None] | None = None


@dataclass(frozen=True)
class PosingSettings:
    """Limits in posing a window, the first ones where its noise is not given.

    - `values_per_unknown`: measured values that each unknown needs: a residual of fewer could not
      tell noise from a wrong fit.
    - `unequal`: ratio of the outputs' residuals, in their guessed scales, above which the outputs
      are weighted anew; below, efficiency gains less than 1 %.
    - `reweightings`: rounds of that at most; two are usual.
    - `most_steps`: of integration in a window, some 50 ms of every candidate; more are a wrong unit
      of time or of `max_step`, and might not end within days.
    """

    values_per_unknown: int = 4
    unequal: float = 1.2
    reweightings: int = 3
    most_steps: int = 10_000_000


POSING = PosingSettings()


def check_misfit(settings: EstimationSettings, method: Method) -> None:
    """Raise ValueError for a fitness or loss that is none, or does not suit the search."""
    fitness, loss = settings.fitness, settings.loss
    if fitness not in FITNESSES:
        raise ValueError(f'unknown fitness {fitness!r}: {suggest(fitness, FITNESSES)}')
    if loss not in LOSSES:
        raise ValueError(f'unknown loss {loss!r}: {suggest(loss, LOSSES)}')
    if method.needs_squares and fitness != 'least_squares':
        raise ValueError(
            f'search {settings.search!r} minimises least squares, not {fitness!r}: '
            "use search='chaotic_de' for that"
        )


def with_starts(settings: EstimationSettings, unknowns: Unknowns) -> EstimationSettings:
    """Return the settings with the means of priors as initial values that are not given.

    Raises ValueError for initial values and priors of what is not estimated.
    """
    unknowns.check_initial(settings.initial)
    priors = settings.priors or {}
    unknowns.check_estimated('a prior', [name for name in priors if priors[name] is not None])
    means = {v.name: v.prior[0] for v in unknowns.model.variables if v.prior}
    return replace(settings, initial={**means, **settings.initial})


def with_process_noise(
    settings: EstimationSettings, model: Model, method: Method
) -> EstimationSettings:
    """Return the settings, `auto` process noise off where there can be none.

    Raises ValueError for a mode that is none, or does not suit the model or the search.
    """
    mode = settings.process_noise
    if mode not in MODES:
        raise ValueError(f'unknown process_noise {mode!r}: {suggest(mode, MODES)}')
    why = without_process_noise(settings, model, method)
    if mode == 'given' and why:
        raise ValueError(f"set process_noise to 'off', not {mode!r}: {why}")
    if mode == 'given' and not any(variable.walk for variable in model.states):
        raise ValueError(
            f"give a state of model {model.name!r} a walk, or set process_noise to 'auto': "
            "'given' finds none"
        )
    if mode == 'auto' and why:
        log.info('process noise is off: %s', why)
        return replace(settings, process_noise='off')
    return settings


def without_process_noise(settings: EstimationSettings, model: Model, method: Method) -> str:
    """Return why there can be no process noise; '' where there can."""
    if not method.needs_squares:
        return f'search {settings.search!r} does without squares'
    if delays := delay_names(model):
        return f'{delays[0]} is estimated, which no filter does; once it is found, give that number'
    return ''
