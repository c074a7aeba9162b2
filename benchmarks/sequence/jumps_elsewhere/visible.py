"""How visible a jump is to all that was measured, whatever the estimator makes of it.

The most powerful test of a jump knows its parameter, its time and the true course, and has only to
fit the initial state, the parameters before and the size. To first order, with s the change of the
outputs in units of the noise by the true size, less all that the other unknowns can make up for,
its -2 log likelihood ratio is s's larger on average where the jump is there (Willsky & Jones 1976,
IEEE Trans. Automatic Control 21, 108-112). What is far below the price of a jump no method tells.
"""

import numpy as np

from benchmarks.sequence.jumps_elsewhere.scenes import Run
from benchmarks.sequence.jumps_elsewhere.truth import Course, trajectory
from benchmarks.sequence.plants import Change, Parameters
from obs_ros.core.typing import Array

STEP = 1e-4  # of a box or a jump, for differences
RANK = 1e-10  # of the largest singular value


def visible(run: Run) -> Array:
    """Return s's of the least visible jump so far, by the end of each window (W,); inf: none yet.

    `run` has white noise and nothing but jumps.
    """
    model, sd = run.scene.experiment.model, np.array(run.scene.experiment.noise)
    p, x0 = run.p[0], run.x[0]

    def outputs(x0: Array, p: Array, changes: tuple[Change, ...] = run.changes) -> Array:
        course = Course(Parameters.of(p, changes))
        x, values = trajectory(model.dynamics, run.t, run.u, x0, course), course.at(run.t)
        rows = [model.output(*each) for each in zip(run.t, x, run.u, values, strict=True)]
        return np.asarray((np.array(rows).reshape(run.t.size, -1) / sd).ravel())

    true = outputs(x0, p)
    nuisance = []
    for i, variable in enumerate((*model.states, *model.parameters)):
        step = STEP * (variable.upper - variable.lower) * np.eye(x0.size + p.size)[i]
        nuisance.append(outputs(x0 + step[: x0.size], p + step[x0.size :]) - true)
    columns = np.array(nuisance).T
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    ends = run.scene.experiment.samples * np.arange(1, run.scene.windows + 1)
    least = np.full(run.scene.windows, np.inf)
    for change in run.changes:
        larger = tuple(
            one._replace(size=(1.0 + STEP) * one.size) if one is change else one
            for one in run.changes
        )
        shape = (outputs(x0, p, larger) - true) / STEP
        for k in np.flatnonzero(run.t[ends] > change.time):
            rows = sd.size * (ends[k] + 1)
            fitted = np.linalg.lstsq(columns[:rows], shape[:rows], rcond=RANK)[0]
            left = shape[:rows] - columns[:rows] @ fitted
            least[k] = min(least[k], float(left @ left))
    return least
