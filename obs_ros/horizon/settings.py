"""Settings of an estimation that are the same from window to window."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from obs_ros.core.model import Model
from obs_ros.core.registry import suggest
from obs_ros.inference.objective import Fitness
from obs_ros.inference.process_noise import MODES, ProcessNoiseMode
from obs_ros.integration.backends import Backend
from obs_ros.optimization.methods import Method


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
      `given` takes the walks of the model's states as they are.
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


def check_process_noise(settings: EstimationSettings, model: Model, method: Method) -> None:
    """Raise ValueError for a mode that is none, or does not suit the model or the search."""
    mode = settings.process_noise
    if mode not in MODES:
        raise ValueError(f'unknown process_noise {mode!r}: {suggest(mode, MODES)}')
    if mode == 'given' and not method.needs_squares:
        raise ValueError(
            f"set process_noise to 'off', not {mode!r}: "
            f'search {settings.search!r} does without squares'
        )
    if mode == 'given' and not any(variable.walk for variable in model.states):
        raise ValueError(
            f"give a state of model {model.name!r} a walk, or set process_noise to 'auto': "
            "'given' finds none"
        )
