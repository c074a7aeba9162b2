"""Laws by which the H-infinity observer adapts parameters, as kernels: gradient and filtered."""

import math
from typing import NamedTuple

import numpy as np

from obs_ros.core.jit import accelerated
from obs_ros.core.typing import Array, IntArray


class Workspace(NamedTuple):
    """The arrays of the observer: n states, q parameters, a of them adapted, r outputs."""

    x: Array  # (n,) the estimate, where all read it
    p: Array  # (q,)
    U: Array  # (n, a) filtered regressor: d x / d (theta / scale)
    P: Array  # (a, a) its covariance
    adapted: IntArray  # (a,) places of theta among the parameters
    L: Array  # (n, r) gains
    G: Array  # (n, r) B (B'B)^-1 H, which turns B Phi2 into Phi2' H
    C: Array  # (r, n) model
    lower: Array  # (n + q,) least values that the observer lets x and p have
    upper: Array  # (n + q,)
    differences: Array  # (n + a,) steps of the states and of theta, for derivatives
    xs: Array  # (n, lanes) candidates: states,
    ps: Array  # (q, lanes) parameters
    ys: Array  # (r, lanes) and outputs
    scale: Array  # (a,)
    filtered: bool  # the settings
    gamma: float
    forgetting: float
    covariance: float


@accelerated
def place(w: Workspace) -> None:
    """Lay out x and p in lane 0 and, with one entry of (x, theta) moved both ways, in the next."""
    x, p, xs, ps, differences = w.x, w.p, w.xs, w.ps, w.differences
    n = x.size
    for lane in range(xs.shape[1]):
        for i in range(n):
            xs[i, lane] = x[i]
        for i in range(p.size):
            ps[i, lane] = p[i]
    for i in range(n):
        xs[i, 1 + 2 * i] += differences[i]
        xs[i, 2 + 2 * i] -= differences[i]
    for i in range(w.adapted.size):
        ps[w.adapted[i], 1 + 2 * (n + i)] += differences[n + i]
        ps[w.adapted[i], 2 + 2 * (n + i)] -= differences[n + i]


@accelerated
def adapt(w: Workspace, e: Array, dt: float) -> None:
    """Go dt seconds on, from candidates propagated over them: x, theta, U and P.

    e (r,) is the error at the begin, NaN where nothing was measured.
    """
    x, p, U, L, C, xs, differences = w.x, w.p, w.U, w.L, w.C, w.xs, w.differences
    lower, upper, filtered, n, a = w.lower, w.upper, w.filtered, w.x.size, w.adapted.size
    seen = np.zeros((e.size, a))  # C U, where measured
    direct, moved = np.empty((n, a)), np.empty((n, a))  # effect of theta / scale on x in dt; U then
    for j in range(a):
        for i in range(e.size):
            if not math.isnan(e[i]):
                for k in range(n):
                    seen[i, j] += C[i, k] * U[k, j]
        for k in range(n):
            lane = 1 + 2 * (n + j)
            difference = xs[k, lane] - xs[k, lane + 1]
            direct[k, j] = w.scale[j] * difference / (2.0 * differences[n + j])
    change = filtered_change(w, seen, e, dt) if filtered else gradient_change(w, direct, e)
    for j in range(a):
        place, theta = n + w.adapted[j], p[w.adapted[j]]
        p[w.adapted[j]] = min(max(theta + w.scale[j] * change[j], lower[place]), upper[place])
        change[j] = (p[w.adapted[j]] - theta) / w.scale[j]
    for k in range(n):
        for j in range(a):
            moved[k, j] = direct[k, j]
            for i in range(n):
                difference = xs[k, 1 + 2 * i] - xs[k, 2 + 2 * i]
                moved[k, j] += difference / (2.0 * differences[i]) * U[i, j]
        x[k] = xs[k, 0]
        for i in range(e.size):
            if not math.isnan(e[i]):
                x[k] += dt * L[k, i] * e[i]
                for j in range(a):
                    moved[k, j] -= dt * L[k, i] * seen[i, j]
        if filtered:
            for j in range(a):
                x[k] += U[k, j] * change[j]
        x[k] = min(max(x[k], lower[k]), upper[k])
    for k in range(n):
        for j in range(a):
            U[k, j] = moved[k, j]


@accelerated
def filtered_change(w: Workspace, seen: Array, e: Array, dt: float) -> Array:
    """Return the change (a,) of theta / scale in dt s by the filtered regressor; P goes on."""
    P, a = w.P, w.adapted.size
    change, along = np.zeros(a), np.zeros(a)
    for j in range(a):
        for k in range(a):
            P[j, k] *= math.exp(w.forgetting * dt)
    # Implicit in P, output by output: the explicit step overshoots below zero when much is learnt
    # at once.
    for i in range(e.size):
        information = 1.0
        for j in range(a):
            along[j] = 0.0
            for k in range(a):
                along[j] += P[j, k] * seen[i, k]
            information += dt * seen[i, j] * along[j]
        for j in range(a):
            for k in range(a):
                P[j, k] -= dt * along[j] * along[k] / information
    limit_variances(P, w.covariance)
    for i in range(e.size):
        if not math.isnan(e[i]):
            for j in range(a):
                for k in range(a):
                    change[j] += dt * P[j, k] * seen[i, k] * e[i]
    return change


@accelerated
def limit_variances(P: Array, most: float) -> None:
    """Shrink the rows and columns of a covariance whose variance is above `most`."""
    for j in range(P.shape[0]):
        if P[j, j] > most:
            share = math.sqrt(most / P[j, j])
            for k in range(P.shape[0]):
                P[j, k] *= share
                P[k, j] *= share


@accelerated
def gradient_change(w: Workspace, direct: Array, e: Array) -> Array:
    """Return the change (a,) of theta / scale by the paper's gradient; Phi2 by its effect on x."""
    G, change = w.G, np.zeros(w.adapted.size)
    for i in range(e.size):
        if not math.isnan(e[i]):
            for k in range(G.shape[0]):
                for j in range(change.size):
                    change[j] += w.gamma * direct[k, j] * G[k, i] * e[i]
    return change
