"""Candidates from one output to the next, for observers that go sample by sample."""

import functools
import time
from typing import Protocol

import numpy as np

from obs_ros.core.model import Model, inside
from obs_ros.core.prior_knowledge import without_knowledge
from obs_ros.core.typing import Array
from obs_ros.integration.backends import Backend, check_backend, compiled_or_numpy, of_model
from obs_ros.integration.filter_step import LiveFilter, run_step
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.steps import STEPS


class Stepper(Protocol):
    """Steps candidates with states x (n, L) and parameters p (q, L), in C order.

    L is `lanes(candidates)`, a multiple of 16; what fills up the lanes must be numbers too. A
    candidate that diverges becomes NaN or infinite and leaves the others alone.
    """

    name: str
    model: Model
    compile_time: float  # s

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """Integrate the states x along the path, in place."""

    def measure(self, t: float, u: Array, x: Array, p: Array, y: Array) -> None:
        """Write the outputs at time t (s) under inputs u (m,) into y (r, L)."""

    def filter(self, live: LiveFilter, path: Path, y: Array) -> None:
        """Take a filter along the path, and correct it by outputs y (r,) there; NaN = not measured.

        The filter is changed in place. Its first call compiles.
        """


class NumpyStepper:
    """Steps candidates without a compiler; see `Stepper` for the methods."""

    name = 'numpy'
    compile_time = 0.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self._step = STEPS[model.method]

    def propagate(self, path: Path, x: Array, p: Array) -> None:
        """See `Stepper.propagate`."""
        states, parameters = tuple(x), tuple(p)
        with np.errstate(all='ignore'):
            for k in range(path.pieces):
                h = path.dt[k] / path.steps[k]
                for j in range(path.steps[k]):
                    s = j * h
                    u0, u1, u2 = (
                        tuple(path.u[k] + after * path.slope[k])
                        for after in (s, s + 0.5 * h, s + h)
                    )
                    states = self._step(
                        self.model.dynamics, path.t[k] + s, h, states, u0, u1, u2, parameters
                    )
        # A discrete model may hand a state on to another one: first all, then in place.
        for row, values in zip(x, [np.array(values) for values in states], strict=True):
            row[:] = values

    def measure(self, t: float, u: Array, x: Array, p: Array, y: Array) -> None:
        """See `Stepper.measure`."""
        with np.errstate(all='ignore'):
            outputs = self.model.output(t, tuple(x), tuple(u), tuple(p))
        for row, values in zip(y, outputs, strict=True):
            row[:] = values

    def filter(self, live: LiveFilter, path: Path, y: Array) -> None:
        """See `Stepper.filter`."""
        with np.errstate(all='ignore'):
            run_step(live, self, path, y)


def stepper_for(model: Model, backend: Backend | None = None) -> Stepper:
    """Return the model's stepper, compiled and ready; `backend` and errors as in `kernels_for`."""
    return _stepper(model, check_backend(backend))


@functools.lru_cache(maxsize=64)
def _stepper(model: Model, backend: str | None) -> Stepper:
    plain = without_knowledge(model)
    if plain is not model:
        return of_model(_stepper(plain, backend), model)

    def compiled() -> Stepper:
        from obs_ros.integration.compiled import CompiledStepper

        stepper = CompiledStepper(model)
        stepper.compile_time = run_once(stepper)
        return stepper

    return compiled_or_numpy(model, backend, compiled, lambda: NumpyStepper(model))


def run_once(stepper: Stepper) -> float:
    """Step one chunk of candidates once, which compiles what that takes; return the seconds."""
    model = stepper.model
    begin = time.perf_counter()
    path = tiny_path(model)
    x = np.repeat([[inside(v)] for v in model.states], LANES, axis=1)
    p = np.repeat([inside(v) for v in model.parameters], LANES).reshape(-1, LANES)
    stepper.propagate(path, x, p)
    stepper.measure(1.0, path.u[0], x, p, np.empty((len(model.outputs), LANES)))
    return time.perf_counter() - begin


def tiny_path(model: Model) -> Path:
    """Return a path of one step, under inputs inside their bounds."""
    u = np.array([[inside(v) for v in model.inputs]] * 2).reshape(2, -1)
    return Path(
        1, np.zeros(2), np.full(2, min(model.max_step, 1.0)), np.ones(2, np.int64), u, 0.0 * u
    )
