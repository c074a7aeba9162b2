"""Tests of a model's structure beside process noise, which whitens what the model leaves out.

White innovations do not show that a model is right: walks follow what its parameters and inputs
ought to explain. Two tests ask for that. With scores g_k = J_k e_k, those of a parameter that is
constant in the window cumulate to a Brownian bridge (Nyblom 1989, J. Am. Stat. Assoc. 84, 223-230):

    L = sum_k (sum_(i <= k) g_i)^2 / (n sum_k g_k^2)

is large for one that moves. And innovations of a right model do not depend on earlier inputs beyond
what the parameters explain (Ljung 1999, section 16.6): regressed on both, those inputs should gain
no more than chi-square.
"""

from dataclasses import dataclass

import numpy as np

from obs_ros.core.chi_square import exceeds
from obs_ros.core.linear_algebra import projected_out, singular
from obs_ros.core.model import names
from obs_ros.core.typing import Array, BoolArray, IntArray
from obs_ros.inference.jumps.hypothesis import Hypothesis


@dataclass(frozen=True)
class StructureSettings:
    """Limits of both tests.

    - `moves`: of L; a constant parameter exceeds it in 3 of 1000 windows, .748 in 1 of 100;
    - `lags`: samples back to which inputs are looked at;
    - `depends`: probability of so much gained by the inputs of a right model.
    """

    moves: float = 1.0
    lags: int = 10
    depends: float = 1e-4


STRUCTURE = StructureSettings()


@dataclass(frozen=True)
class Structure:
    """Which estimated parameters (q,) move inside a window, and inputs that leave their mark."""

    moving: BoolArray
    inputs: tuple[str, ...]

    def words(self, parameters: tuple[str, ...]) -> str:
        """Say so; '' if nothing speaks against the model."""
        said = []
        moving = [name for name, moves in zip(parameters, self.moving, strict=True) if moves]
        if moving:
            said.append(f'{" and ".join(moving)} not constant in the window')
        if self.inputs:
            said.append(f'the residual depends on earlier {" and ".join(self.inputs)}')
        return ', '.join(said)


def structure_of(best: Hypothesis, settings: StructureSettings = STRUCTURE) -> Structure:
    """Return the tests of a hypothesis without jumps, whose residuals are white innovations."""
    objective = best.problem.objective
    unknowns, grid = objective.unknowns, objective.grid
    J, e = best.linearisation.jacobian, best.linearisation.residual
    scores = J[:, unknowns.n_states :] * e[:, None]
    scores = scores - scores.mean(axis=0)
    with np.errstate(all='ignore'):
        L = (np.cumsum(scores, axis=0) ** 2).sum(axis=0) / (len(e) * (scores**2).sum(axis=0))
    moving = np.nan_to_num(L) > settings.moves
    moving[np.isfinite(unknowns.walks)] = False
    nodes = np.asarray(np.nonzero(grid.weight > 0.0)[0], dtype=np.int64)
    tail = settings.depends / max(1, grid.u.shape[1])
    marked = [
        name
        for name, u in zip(names(unknowns.model.inputs), grid.u.T, strict=True)
        if _depends(e, J, _lagged(u, nodes, settings.lags), tail)
    ]
    return Structure(np.asarray(moving), tuple(marked))


def _lagged(u: Array, nodes: IntArray, lags: int) -> Array:
    """Return an input (K,) at 1 to `lags` samples before each of the nodes (M,): (M, lags)."""
    return np.column_stack([u[np.maximum(nodes - lag, 0)] for lag in range(1, lags + 1)])


def _depends(e: Array, J: Array, U: Array, tail: float) -> bool:
    """Whether columns U (M, any) explain more of e (M,), beside J (M, D), than chance would."""
    if len(e) < 2 * (U.shape[1] + J.shape[1]) or not np.isfinite(J).all():
        return False
    U = U - U.mean(axis=0)
    scale = np.sqrt((J**2).sum(axis=0))
    base = J[:, scale > 0.0] / scale[scale > 0.0]
    U = projected_out(base, U)
    size = np.sqrt((U**2).sum(axis=0))
    told = size > 1e-6 * max(float(size.max(initial=0.0)), np.finfo(float).tiny)
    if not told.any():
        return False
    left, s, _ = singular(U[:, told] / size[told])
    left = left[:, s > 1e-6 * s[0]]
    gained = float(np.sum((left.T @ e) ** 2) / np.mean(e**2))
    return exceeds(gained, left.shape[1], tail)
