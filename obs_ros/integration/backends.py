"""A whole population of candidates through a window: compiled where Numba is, else on NumPy."""

import copy
import functools
import importlib.util
import logging
import os
import re
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeVar

import numpy as np

from obs_ros.core.deadline import uncounted
from obs_ros.core.model import Model, inside
from obs_ros.core.model_check import source_line
from obs_ros.core.prior_knowledge import without_knowledge
from obs_ros.core.record import Record
from obs_ros.core.typing import Array, IntArray
from obs_ros.integration.delayed import DelayedKernels, delay_names
from obs_ros.integration.filter_pass import FilterPass
from obs_ros.integration.grid import Grid
from obs_ros.integration.linear_path import LinearPath
from obs_ros.integration.smoother import smoothed
from obs_ros.integration.vectorised import NumpyKernels

if TYPE_CHECKING:
    from obs_ros.integration.compiled import CompiledKernels

Backend = Literal['numba', 'numpy']
Made = TypeVar('Made')

TINY_TOLERANCE = 1e-3  # of own steps of a window that only compiles

log = logging.getLogger(__name__)

# Threads that ask for a model at the same time get the same kernels, made once.
_MAKING = threading.RLock()


class Kernels(Protocol):
    """Rollouts of candidates with initial states x0 (n, B) and parameters p (q, B) over a grid.

    A candidate that diverges yields NaN or infinity and leaves the others alone.
    """

    name: str
    model: Model
    compile_time: float  # s
    own_steps: bool  # whether candidates take steps of their own on grids that have a tolerance

    def squares(self, grid: Grid, prefixes: IntArray, x0: Array, p: Array) -> Array:
        """Sum the squared residuals, in units of the outputs' scales, block by block.

        prefixes (G,) are rising numbers of nodes; block g of the result (G, r, B) sums over the
        nodes from prefixes[g - 1] (0 at first) to prefixes[g] - 1.
        """

    def grams(self, grid: Grid, nodes: int, x0: Array, p: Array, width: int) -> Array:
        """Sum products of residuals and output differences over the first `nodes` nodes.

        Every start owns `width` neighbouring candidates: its base point, then perturbed ones.
        In the result (starts, width, width), row and column 0 stand for the base point's residuals,
        row and column j for the outputs of candidate j less the base's.
        """

    def trajectories(self, grid: Grid, x0: Array, p: Array, width: int = 1) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) at every node.

        Of `width` neighbouring candidates the others take the steps of the first, for differences.

        With an injection (see `Injection`) the states are those after the updates, and outputs that
        were measured those from which the innovations are: y - e.
        """

    def scheduled(
        self, grid: Grid, x0: Array, p: Array, along: IntArray, there: IntArray, width: int = 1
    ) -> tuple[Array, Array]:
        """Return states (K, n, B) and outputs (K, r, B) under parameters that change.

        Of the sets p (S, q, B) the one between two nodes is along[k] (K,), that at a node there[k]
        (K,). Steps of `width` neighbours are as in `trajectories`; there is no injection.
        """

    def counts(self, grid: Grid, x0: Array, p: Array) -> IntArray:
        """Return the steps (K - 1, B) that candidates take in the intervals, tried in vain too."""

    def restarted(self, grid: Grid, states: Array, p: Array) -> Array:
        """Return the states (K - 1, n, B) to which each interval leads from its begin.

        There they are states (K, n, B); no measurement corrects them.
        """

    def one_step(
        self, grid: Grid, states: tuple[Array, Array], moved: Array, sets: Array, along: IntArray,
        there: IntArray,
    ) -> tuple[Array, Array]:  # fmt: skip
        """Return differences at the ends of intervals, by moved states and parameters at the begin.

        They are differences (K - 1, n, n + J) of the states at the end, and (K, r, n + J) of the
        outputs at the node itself. Two sets of states (K, n) at the nodes, those that are measured
        and those that intervals begin with, are moved (n,), one at a time. Of the sets of
        parameters (S, q, 1 + J), the first not moved and the others one at a time, the one along[k]
        (K,) holds between two nodes, that there[k] at a node. Nothing corrects them.
        """

    def paths(self, grid: Grid, x0: Array, p: Array) -> tuple[Array, Array, Array]:
        """Return states (K, n, B), parameters (K, q, B) and outputs (K, r, B) at every node.

        As `trajectories`, for parameters that move along the window.
        """

    def filter(
        self, grid: Grid, x0: Array, p: Array, walks: Array, noise: Array,
        P0: Array | None = None, moving: IntArray | None = None,
    ) -> FilterPass:  # fmt: skip
        """Run the extended Kalman filter along the grid from one candidate x0 (n,), p (q,).

        walks (n + q,), finite, are in units of the variables per square root of a second; noise
        (r,) are the outputs' standard deviations, above 0; P0 (n + q, n + q) is the covariance
        before the first node's outputs, none where missing. Parameters `moving` (w,) are linearised
        as states; missing, those that have a walk or a variance. An injection is left aside.
        """


def kernels_for(model: Model, backend: Backend | None = None) -> Kernels:
    """Return the model's rollouts, each compiled when it is first called.

    `backend` None means $OBS_ROS_BACKEND if set, else Numba if it is there, else NumPy. Where Numba
    does not work or cannot compile the model, NumPy is used with a warning that says why: one
    kernel is compiled here. No deadline counts the time of that.

    Raises ValueError for another backend; with backend `numba`, ImportError where Numba does not
    work and ValueError where it cannot compile the model.
    """
    with uncounted(), _MAKING:
        return _kernels(model, check_backend(backend))


@functools.lru_cache(maxsize=64)
def _kernels(model: Model, backend: str | None) -> Kernels:
    plain = without_knowledge(model)
    if plain is not model:
        return of_model(_kernels(plain, backend), model)

    def compiled() -> Kernels:
        from obs_ros.integration.compiled import CompiledKernels

        kernels = with_delays(CompiledKernels(model))
        kernels.compile_time = run_once(kernels)
        return kernels

    return compiled_or_numpy(model, backend, compiled, lambda: with_delays(NumpyKernels(model)))


def with_delays(kernels: 'CompiledKernels | NumpyKernels') -> Kernels:
    """Return the kernels themselves, or those for a model whose delays are estimated."""
    return DelayedKernels(kernels) if delay_names(kernels.model) else kernels


def of_model(made: Made, model: Model) -> Made:
    """Return the same code for a model that differs in walks and priors only: nothing compiles."""
    other: Any = copy.copy(made)
    other.model = model
    return other  # type: ignore[no-any-return]


def compiled_or_numpy(
    model: Model, backend: str | None, compiled: Callable[[], Made], plain: Callable[[], Made]
) -> Made:
    """Return what `compiled` makes, or else, with a warning that says why, what `plain` makes.

    Backend and errors are as in `kernels_for`.
    """
    if backend == 'numpy' or (backend is None and importlib.util.find_spec('numba') is None):
        return plain()
    try:
        from obs_ros.integration.compiled import CompileError
    except ImportError as error:
        reason = f'Numba does not work here: {error}'
        if backend == 'numba':
            raise ImportError(f'{reason}; pip install numba') from error
        log.warning('%s; NumPy is used, which is slower', reason)
        return plain()
    try:
        return compiled()
    except (CompileError, ValueError) as error:
        reason = f'model {model.name!r} cannot be compiled: {gist(str(error))}'
        if backend == 'numba':
            raise ValueError(reason) from error
        _tell(reason)
        return plain()


@functools.lru_cache(maxsize=64)
def _tell(reason: str) -> None:
    """Say once, for rollouts, steppers and all, why a model is not compiled."""
    log.warning('%s; NumPy is used, which is slower', reason)


def gist(message: str, longest: int = 400) -> str:
    """Return the part of a compiler's message about the user's code, in `longest` characters.

    Its last words are the user's line, as far down as the compiler knows it.
    """
    words = re.sub(r'Failed in nopython mode pipeline \(step: [\w ]*\)', '', message)
    words = re.split(r'During: |File "', words)[0]
    own = Path(__file__).parents[1]
    places = [
        (file, int(number))
        for file, number in re.findall(r'File "([^"]+)", line (\d+)', message)
        if Path(file).is_file() and own not in Path(file).parents
    ]
    text = ' '.join(words.split())[:longest]
    return f'{text} ({source_line(*places[-1])})' if places else text


def check_backend(backend: str | None) -> str | None:
    """Return the backend asked for here or in $OBS_ROS_BACKEND; ValueError if there is no such."""
    chosen = backend or os.environ.get('OBS_ROS_BACKEND') or None
    if chosen not in (None, 'numba', 'numpy'):
        raise ValueError(f"backend {chosen!r} is neither 'numba' nor 'numpy'")
    return chosen


def run_once(kernels: Kernels) -> float:
    """Run the smallest kernel once on a tiny window, which compiles it; return the seconds."""
    begin = time.perf_counter()
    kernels.trajectories(*tiny_window(kernels.model))
    return time.perf_counter() - begin


def rollouts_rehearsed(kernels: Kernels) -> Iterator[None]:
    """Run once, which compiles it, what every window needs: one kernel at a time."""
    grid, x0, p = tiny_window(kernels.model)
    own = [replace(grid, tolerance=TINY_TOLERANCE, budget=1)] if kernels.own_steps else []
    for each in (grid, *own):
        kernels.trajectories(each, x0, p)
        yield
        kernels.squares(each, np.array([2]), x0, p)
        yield
        kernels.grams(each, 2, x0, p, 1)
        yield
    kernels.restarted(grid, np.repeat(x0[None], 2, axis=0), p)
    yield


def correction_rehearsed(kernels: Kernels, moving: IntArray | None = None) -> Iterator[None]:
    """Run once, which compiles it, what only process noise needs: one kernel at a time.

    `moving` (w,) are the parameters that will move: their number is compiled in.
    """
    grid, x0, p = tiny_window(kernels.model)
    walks, noise = np.zeros(len(x0) + len(p)), np.ones(grid.y.shape[1])
    found = kernels.filter(grid, x0[:, 0], p[:, 0], walks, noise, moving=moving)
    yield
    smoothed(found)
    yield
    LinearPath.of(found).neg2_log_likelihood(walks[:, None], noise[:, None])
    yield
    corrected = grid.injected(found.injection, found.S)
    kernels.squares(corrected, np.array([2]), x0, p)
    yield
    kernels.grams(corrected, 2, x0, p, 1)
    yield
    kernels.paths(corrected, x0, p)
    yield


def tiny_window(model: Model) -> tuple[Grid, Array, Array]:
    """Return a window of two nodes, and one candidate x0 (n, 1), p (q, 1)."""
    record = Record(
        t=np.array([0.0, min(model.max_step, 1.0)]),
        u=np.full((2, len(model.inputs)), [inside(v) for v in model.inputs]),
        y=np.zeros((2, len(model.outputs))),
    )
    x0 = np.array([[inside(v)] for v in model.states])
    p = np.array([inside(v) for v in model.parameters]).reshape(-1, 1)
    return Grid.of(model, record, np.ones(len(model.outputs))), x0, p
