"""The true profile likelihood of a window's parameters, by scipy, offline and finely.

Each parameter is pinned, all other unknowns are optimised inside their boxes, and its value moves
until the squares, in the noise's variance, have grown by DELTA: Venzon & Moolgavkar 1988; Raue et
al. 2009. Only the integration is shared with the library.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from benchmarks.coverage.run import likelihood_of
from benchmarks.judge import Judge
from benchmarks.zoo.experiments import EXPERIMENTS, Drawn, Experiment, run
from obs_ros.core.model import names
from obs_ros.core.typing import Array

DELTA = 3.84  # growth of the squares at the ends of a 95 % interval
ENDS = float(np.sqrt(DELTA))
CLOSE = 0.02  # of the root of the growth, of an end
STARTS = 4  # about the truth, beside it
SPREAD = 0.02  # of the box: of the starts
FIRST_STEP = 0.01  # of the box, where the curvature tells none
LONGEST = 0.1  # of the box: a walk's step
SHORTEST = 1e-7  # of the box: a bracket that is an end
FTOL, XTOL, EVALUATIONS = 1e-8, 1e-8, 150


class Profile(NamedTuple):
    """Ends (q, 2) of the parameters' true intervals in their units; infinite beyond a bound.

    `best` (q,) are their values at the optimum, whose squares are `least`.
    """

    ends: Array
    best: Array
    least: float


def profiled(name: str, rich: bool, seed: int) -> Profile:
    """Return the profile of the window that `run.tracked` solves alone."""
    experiment = EXPERIMENTS[name]
    return profile(experiment, run(experiment, seed, rich), seed)


def profile(experiment: Experiment, drawn: Drawn, seed: int) -> Profile:
    """Return the ends of all parameters of a window."""
    model = experiment.model
    known = names(model.variables)
    likelihood = likelihood_of(experiment, drawn)
    truth = likelihood.point(dict(zip(known, [*drawn.x[0], *drawn.p], strict=True)))
    rng = np.random.default_rng([seed, len(known)])
    starts = truth + SPREAD * rng.standard_normal((STARTS, truth.size))
    best = min((polished(likelihood, z) for z in [truth, *starts]), key=lambda found: found[1])
    places = range(len(model.states), len(known))
    while True:
        ends = []
        for i in places:
            walk = Walk(likelihood, i, *best)
            pair = [walk.end(side) for side in (-1.0, 1.0)]
            if walk.lower is not None:
                best = walk.lower
                break
            ends.append(pair)
        else:
            break
    unit = np.array([best[0][i] for i in places])
    low, width = (each[list(places)] for each in (likelihood.lower, likelihood.width))
    return Profile(low[:, None] + width[:, None] * np.array(ends), low + width * unit, best[1])


class Walk:
    """The walk of one unknown away from the optimum `z` (d,), whose squares are `least`.

    `lower` is a point of fewer squares with them, if the walk meets one.
    """

    def __init__(self, likelihood: Judge, place: int, z: Array, least: float) -> None:
        self._likelihood, self._place, self._z, self._least = likelihood, place, z, least
        self.lower: tuple[Array, float] | None = None
        jacobian = likelihood.jacobian(np.clip(z, 1e-5, 1.0 - 1e-5))
        gram = jacobian.T @ jacobian
        gram[np.diag_indices_from(gram)] += 1.0
        self._step = ENDS * float(np.sqrt(np.linalg.inv(gram)[place, place]))

    def end(self, side: float) -> float:
        """Return the end on a side in the unit box, infinite where the bound comes first."""
        bound = 0.5 + 0.5 * side
        inner, at_inner, z = self._z[self._place], 0.0, self._z
        step = min(max(self._step, 1e-6), LONGEST)
        outer, at_outer = np.nan, np.nan
        while self.lower is None and not np.isfinite(outer):
            if inner == bound:
                return side * np.inf
            value = float(np.clip(inner + side * step, 0.0, 1.0))
            grown, moved = self.growth(value, z)
            if grown > ENDS:
                outer, at_outer = value, grown
            else:
                slope = max((grown - at_inner) / abs(value - inner), 1e-9)
                step = min(1.05 * (ENDS - grown) / slope + SHORTEST, 2.0 * step, LONGEST)
                inner, at_inner, z = value, grown, moved
        return self._between(inner, at_inner, outer, at_outer, z)

    def growth(self, value: float, start: Array) -> tuple[float, Array]:
        """Return the root of the growth of the squares with the unknown pinned, and the point."""
        z = start.copy()
        z[self._place] = value
        z, squares = polished(self._likelihood, z, pinned=self._place)
        if squares < self._least - 1e-2:
            self.lower = polished(self._likelihood, z)
        return float(np.sqrt(max(squares - self._least, 0.0))), z

    def _between(
        self, inner: float, at_inner: float, outer: float, at_outer: float, z: Array
    ) -> float:
        """Return where the root of the growth is ENDS, between two values that it lies between."""
        for _ in range(25):
            if self.lower is not None or abs(outer - inner) < SHORTEST:
                break
            share = (ENDS - at_inner) / (at_outer - at_inner)
            value = inner + float(np.clip(share, 0.05, 0.95)) * (outer - inner)
            grown, moved = self.growth(value, z)
            if abs(grown - ENDS) < CLOSE:
                return value
            if grown > ENDS:
                outer, at_outer = value, grown
            else:
                inner, at_inner, z = value, grown, moved
        return inner


def polished(likelihood: Judge, z: Array, pinned: int | None = None) -> tuple[Array, float]:
    """Return the optimum (d,) from a start in the unit box, one unknown pinned, and its squares."""
    free = np.array([i for i in range(z.size) if i != pinned])

    def whole(part: Array) -> Array:
        full = z.copy()
        full[free] = part
        return full

    found = least_squares(
        lambda part: likelihood.residuals(whole(part)),
        np.clip(z[free], 1e-9, 1.0 - 1e-9),
        lambda part: likelihood.jacobian(whole(part))[:, free],
        bounds=(0.0, 1.0), method='trf', x_scale='jac',
        ftol=FTOL, xtol=XTOL, gtol=None, max_nfev=EVALUATIONS,
    )  # fmt: skip
    return whole(found.x), 2.0 * float(found.cost)
