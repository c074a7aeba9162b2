"""Models fed with measurements: a population of parameters through a window, one step at a time."""

import functools
import time
from typing import Protocol

import numpy as np

from obs_ros.core.model import Model, inside
from obs_ros.core.prior_knowledge import without_knowledge
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.backends import Backend, check_backend, compiled_or_numpy, of_model
from obs_ros.integration.path import LANES, Stretch
from obs_ros.integration.steps import axpy


class SeriesParallel(Protocol):
    """Steps a plant whose outputs are states of it, with forward Euler.

    Before each interval but the first, the states that were measured at its begin are replaced by
    the measurement (in the words of Narendra & Annaswamy 1989, the series-parallel model). States
    are kept within lower and upper (n,). A candidate that diverges yields NaN or infinity.
    """

    model: Model
    measured: IntArray  # the state (r,) that each output is

    def pursue(
        self, window: Stretch, lower: Array, upper: Array, x0: Array, p: Array
    ) -> tuple[Array, Array]:
        """Return squared errors (L,), summed over the window in units of the scales, and states.

        All candidates start from x0 (n,); p (q, L) are their parameters, with L a multiple of 16.
        The error at a node is the output measured less the state predicted there. The states (n, L)
        are those predicted at the last node.
        """


def measured_states(model: Model) -> IntArray:
    """Return which state each output is; raises ValueError if one is no state as it stands."""
    x = tuple(np.random.default_rng(0).uniform(0.1, 0.9, (2, len(model.states))).T)
    u = tuple(np.full(2, inside(variable)) for variable in model.inputs)
    p = tuple(np.full(2, inside(variable)) for variable in model.parameters)
    found = []
    for variable, y in zip(model.outputs, model.output(0.0, x, u, p), strict=True):
        same = [i for i, state in enumerate(x) if np.array_equal(state, y)]
        if not same:
            raise ValueError(
                f'model {model.name!r}: output {variable.name} is none of the states, which are '
                'to be replaced by what is measured'
            )
        found.append(same[0])
    return np.array(found, dtype=np.int64)


class NumpySeriesParallel:
    """Without a compiler; see `SeriesParallel` for the methods."""

    name = 'numpy'

    def __init__(self, model: Model) -> None:
        self.model = model
        self.measured = measured_states(model)

    def pursue(
        self, window: Stretch, lower: Array, upper: Array, x0: Array, p: Array
    ) -> tuple[Array, Array]:
        """See `SeriesParallel.pursue`."""
        x = [np.full(p.shape[1], xi) for xi in x0]
        squares = np.zeros(p.shape[1])
        parameters = tuple(p)
        with np.errstate(all='ignore'):
            for k in range(window.dt.size):
                for i, state in enumerate(self.measured):
                    if k > 0 and window.known[k, i]:
                        x[state] = np.full(p.shape[1], window.y[k, i])
                rates = self.model.dynamics(window.t[k], tuple(x), tuple(window.u[k]), parameters)
                x = [
                    np.clip(xi, low, high)
                    for xi, low, high in zip(
                        axpy(x, window.dt[k], rates), lower, upper, strict=True
                    )
                ]
                for i, state in enumerate(self.measured):
                    if window.known[k + 1, i]:
                        squares += (window.weight[i] * (window.y[k + 1, i] - x[state])) ** 2
        return squares, np.array(x)


def series_parallel_for(model: Model, backend: Backend | None = None) -> SeriesParallel:
    """Return the model's steps, compiled and ready; `backend` and errors as in `kernels_for`.

    Raises ValueError, too, for a model with an output that is no state.
    """
    return _series_parallel(model, check_backend(backend))


@functools.lru_cache(maxsize=64)
def _series_parallel(model: Model, backend: str | None) -> SeriesParallel:
    plain = without_knowledge(model)
    if plain is not model:
        return of_model(_series_parallel(plain, backend), model)

    measured_states(model)  # refuses before anything is compiled

    def compiled() -> SeriesParallel:
        from obs_ros.integration.compiled import CompiledSeriesParallel

        made = CompiledSeriesParallel(model, measured_states(model))
        run_once(made)
        return made

    return compiled_or_numpy(model, backend, compiled, lambda: NumpySeriesParallel(model))


def run_once(made: SeriesParallel) -> float:
    """Follow one interval once, which compiles what that takes; return the seconds."""
    model = made.model
    begin = time.perf_counter()
    r = len(model.outputs)
    window = Stretch(
        np.zeros(1), np.full(1, 1e-3), np.array([[inside(v) for v in model.inputs]]).reshape(1, -1),
        np.zeros((2, r)), np.ones((2, r), dtype=np.bool_), np.ones(r),
    )  # fmt: skip
    x0 = np.array([inside(v) for v in model.states])
    p = np.repeat([inside(v) for v in model.parameters], LANES).reshape(-1, LANES)
    made.pursue(window, np.full(x0.size, -np.inf), np.full(x0.size, np.inf), x0, p)
    return time.perf_counter() - begin
