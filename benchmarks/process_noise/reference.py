"""A reference that shares no inference with obs_ros: maximum likelihood from the truth.

Parameters, initial state, walks (one for all states of a unit that walk) and noise minimise -2 log
p(y) of an extended Kalman filter of its own, within the model's bounds (SLSQP; no prior).
"""

import numpy as np
from scipy.optimize import minimize

from benchmarks.process_noise.compiled import likelihood_of
from benchmarks.process_noise.plants import Plant
from obs_ros import Record
from obs_ros.core.typing import Array

DIFFERENCE = 1e-4  # of the gradient, in units of an unknown's scale
CURVED = 0.01  # of the box, and of a logarithm: where curvature is measured first
MOST = 100  # iterations
TOLERANCE = 1e-5  # of -2 log p


def most_likely(plant: Plant, record: Record, x0: Array, p: Array, walk: float) -> Array:
    """Return the parameters (q,) of the likelihood's optimum near the truth x0 (n,), p (q,)."""
    model, likelihood = plant.model, likelihood_of(plant.model)
    n, estimated = x0.size, plant.estimated
    units = list(dict.fromkeys(model.states[i].unit for i in plant.walking)) if walk > 0.0 else []
    groups = [[i for i in plant.walking if model.states[i].unit == unit] for unit in units]
    size = np.array([v.upper - v.lower for v in model.states])
    u, steps = np.ascontiguousarray(record.u), int(np.ceil(plant.interval / model.max_step / 1.01))
    boxes = [*model.states, *(model.parameters[i] for i in estimated)]
    start = np.concatenate([x0, p[estimated], np.full(len(units), np.log(walk or 1.0)),
                            np.log(plant.noise)])  # fmt: skip
    free = start.size - len(boxes)
    low = np.array([v.lower for v in boxes] + [-np.inf] * free)
    high = np.array([v.upper for v in boxes] + [np.inf] * free)

    def neg2(theta: Array) -> float:
        parameters, walks = p.copy(), np.zeros(n)
        parameters[estimated] = theta[n : len(boxes)]
        for group, log in zip(groups, theta[len(boxes) :], strict=False):
            walks[group] = np.exp(log)
        noise = np.exp(theta[len(boxes) + len(groups) :])
        return likelihood(
            record.t, u, record.y, theta[:n].copy(), parameters, walks, noise, size, steps
        )

    scale = scales(neg2, start, np.where(np.isfinite(high - low), high - low, 1.0))

    def criterion(s: Array) -> tuple[float, Array]:
        theta = start + scale * s
        sides = DIFFERENCE * np.diag(scale)
        slope = [neg2(theta + side) - neg2(theta - side) for side in sides]
        return neg2(theta), np.array(slope) / (2.0 * DIFFERENCE)

    bounds = list(zip((low - start) / scale, (high - start) / scale, strict=True))
    found = minimize(
        criterion, np.zeros(start.size), jac=True, method='SLSQP', bounds=bounds,
        options={'maxiter': MOST, 'ftol': TOLERANCE},
    )  # fmt: skip
    best = p.copy()
    best[estimated] = (start + scale * found.x)[n : len(boxes)]
    return best


def scales(neg2, start: Array, width: Array) -> Array:
    """Return steps (d,) by each of which -2 log p rises by about one."""
    found = CURVED * width
    for _ in range(2):
        bends = np.array([
            neg2(start + side) - 2.0 * neg2(start) + neg2(start - side) for side in np.diag(found)
        ])  # fmt: skip
        found = found * np.clip(np.sqrt(2.0 / np.maximum(bends, 1e-12)), 1e-4, 10.0)
    return found
