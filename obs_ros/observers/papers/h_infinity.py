"""H-infinity adaptive observer: Alvarado-Méndez et al. 2024, eq. 4, and a filtered regressor."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.jit import bound
from obs_ros.core.linear_algebra import singular
from obs_ros.core.model import Model, inside, names
from obs_ros.core.texts import listing
from obs_ros.core.typing import Array
from obs_ros.integration.path import Path, lanes
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.papers.adaptation import Workspace, adapt, place
from obs_ros.observers.papers.adaptive_gains import AdaptiveGains, gains_of, stored_gains
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting

RANK = 1e-12  # of the largest singular value: less is rounding


@dataclass(frozen=True)
class HInfinitySettings(Settings):
    """Settings of the H-infinity adaptive observer."""

    adaptation: str = setting(
        'filtered', "filtered regressor, or the paper's gradient", choices=('filtered', 'gradient')
    )
    gains: str = setting(
        'designed', 'gains of a built-in model: designed here, or printed by the paper; of any '
        'model: the path of a file that the design kept', read_only=True,
    )  # fmt: skip
    L: tuple[float, ...] = setting(
        (math.nan,), 'gain of the states in place of those, row by row: states x outputs',
        nan=True, lower=-1e12, upper=1e12,
    )  # fmt: skip
    B: tuple[float, ...] = setting(
        (math.nan,), 'beside L, for the gradient: where B Phi2 theta enters, states x columns',
        nan=True, lower=-1e12, upper=1e12,
    )  # fmt: skip
    H: tuple[float, ...] = setting(
        (math.nan,), 'beside L, for the gradient: its gain, columns of B x outputs',
        nan=True, lower=-1e12, upper=1e12,
    )  # fmt: skip
    scale: tuple[float, ...] = setting(
        (math.nan,), 'size of the parameters, one for all or one for each: gamma, covariance and '
        "forgetting are for theta / scale; nan: the gains' own, or the width of the bounds",
        'of theta', nan=True, positive=True, upper=1e12,
    )  # fmt: skip
    gamma: float = setting(125.0, 'Gamma, gain of the gradient', positive=True, upper=1e12)
    forgetting: float = setting(
        0.05, 'rate at which the filtered regressor forgets', '1/s', lower=0.0, upper=1e6
    )
    covariance: float = setting(
        1e9, 'largest covariance of the filtered regressor, and its first', positive=True,
        upper=1e18,
    )  # fmt: skip


class HInfinityObserver(RecursiveObserver):
    """States by a fixed gain, parameters by adaptation.

        x' = A x + Psi(x, u) + B Phi2(x, u) theta + N eta,   y = C x
        xhat' = f(xhat, u, theta) + L e,   e = y - C xhat

    `gradient` (eq. 4, theta = scale q):  q' = Gamma Phi2(xhat, u)' H e. The paper takes theta in
    N/m, which with its Gamma moves kt by less than 0.001 N/m in 65 s. Its theorem has no solution
    for the suspension, so nothing vouches for this law there.

    `filtered`: U' = (J - L C) U + B Phi2, q' = P (C U)' e, P' = forgetting P - P (C U)'(C U) P
    with no variance above `covariance`, J the derivative of f, and U q' added to xhat'. This
    converges where C U is persistently exciting, whatever L makes A - L C stable.

    The gains come from `gains`, by name or file (see `design.h_infinity`), or as `L`, with B and H
    for the gradient. Adapted are the `parameters` given, by default all that the gains are for, or
    with `L` all that are not `fixed`. Each stays within its bounds, states within ten times their
    range; the other parameters are what they are held at. Derivatives are differences along each
    step; outputs must be linear in the states. Steps are the model's `max_step` at most, y a
    straight line between outputs; one that is missing corrects nothing.

    `figures` holds `excitation`, |C U| in outputs per scale of theta, and `covariance`, the
    largest variance.

    Raises ValueError for a model without gains, for gains of the wrong size or that cannot be read,
    and when `parameters` names one that the gains are not for, or `fixed` one that is adapted.
    """

    Settings = HInfinitySettings
    settings_decide = True  # by the gains
    beyond: ClassVar[float] = 4.5  # ranges beyond its bounds that a state may go, on each side

    def __init__(self, model: Model | str, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        n, r = len(self.model.states), len(self.model.outputs)
        s = self.settings
        gains = self._gains()
        chosen = self._adapted(gains)
        adapted = np.array([names(self.model.parameters).index(name) for name in chosen])
        known = [gains.parameters.index(name) for name in chosen]
        width = (self.upper - self.lower)[[*range(n), *(n + adapted)]]
        lower, upper = self.lower.copy(), self.upper.copy()
        lower[:n] -= self.beyond * width[:n]
        upper[:n] += self.beyond * width[:n]
        count = lanes(1 + 2 * (n + adapted.size))
        self.workspace = Workspace(
            x=self.x,
            p=self.p,
            U=np.zeros((n, adapted.size)),
            P=np.zeros((adapted.size, adapted.size)),
            adapted=adapted,
            L=gains.L,
            G=self._gradient_gain(gains, (n, r)),
            C=self._output_matrix(),
            lower=lower,
            upper=upper,
            differences=self.difference * width,
            xs=np.zeros((n, count)),
            ps=np.zeros((self.p.size, count)),
            ys=np.zeros((r, count)),
            scale=_sizes(s.scale, gains.scale[known]),
            filtered=s.adaptation == 'filtered',
            gamma=s.gamma,
            forgetting=s.forgetting,
            covariance=s.covariance,
        )

    @classmethod
    def suits(cls, model: Model) -> None:
        stored_gains(model, HInfinitySettings.gains)

    def _gains(self) -> AdaptiveGains:
        """Return the gains that the settings give or name."""
        s = self.settings
        L, B, H = (_given(name, getattr(s, name)) for name in ('L', 'B', 'H'))
        if not L:
            if B or H:
                raise ValueError('give L beside B and H, which belong to it')
            return stored_gains(self.model, s.gains)
        given, fixed = self._arguments['parameters'], self._arguments['fixed'] or {}
        every = names(self.model.parameters)
        chosen = [name for name in every if name not in fixed] if given is None else given
        return gains_of(self.model, tuple(chosen), L, B, H)

    def _adapted(self, gains: AdaptiveGains) -> tuple[str, ...]:
        """Return the names of the parameters that are adapted."""
        given = self._arguments['parameters']
        chosen = gains.parameters if given is None else tuple(given)
        for name in chosen:
            if name not in gains.parameters:
                raise ValueError(
                    f'adapt {listing(gains.parameters)} of {self.model.name}, which the gains are '
                    f'for, not {name}'
                )
            if name in (self._arguments['fixed'] or {}):
                raise ValueError(f'leave {name} free: HInfinityObserver adapts it')
        if not chosen:
            raise ValueError(f'adapt at least one of {listing(gains.parameters)}, not none')
        return chosen

    def _gradient_gain(self, gains: AdaptiveGains, shape: tuple[int, int]) -> Array:
        """Return B (B'B)^-1 H (n, r), zeros where nothing adapts by it."""
        if self.settings.adaptation == 'filtered':
            return np.zeros(shape)
        if not gains.H.size:
            raise ValueError("give B and H beside L, or take adaptation 'filtered': "
                             'the gradient needs them')  # fmt: skip
        left, sizes, right = singular(gains.B)
        rank = int((sizes > RANK * sizes.max()).sum())
        if rank < gains.B.shape[1]:
            raise ValueError(f'give B independent columns: it has less than full rank, {rank}')
        return np.ascontiguousarray((left / sizes) @ right @ gains.H)

    def _output_matrix(self) -> Array:
        """Return C (r, n), the outputs' change with each state."""
        u, p = (tuple(inside(v) for v in g) for g in (self.model.inputs, self.model.parameters))
        rest = np.array([inside(v) for v in self.model.states])
        columns = []
        for i in range(rest.size):
            ends = []
            for step in (-1.0, 1.0):
                x = rest.copy()
                x[i] += step
                ends.append(np.array(self.model.output(0.0, tuple(x), u, p)))
            columns.append(0.5 * (ends[1] - ends[0]))
        return np.ascontiguousarray(np.array(columns).T)

    def _start(self, now: Instant) -> None:
        w, self._stepper = self.workspace, self.stepper
        self._place, self._adapt = bound(place, w), bound(adapt, w, now.y, 0.0)
        w.U[:] = 0.0
        w.P[:] = self.settings.covariance * np.eye(w.adapted.size)
        self._innovate(now)

    def _step(self, before: Instant, now: Instant, path: Path) -> None:
        w = self.workspace
        begin = np.where(np.isnan(before.y), now.y, before.y)
        slope = (np.where(np.isnan(now.y), begin, now.y) - begin) / path.dt[: path.pieces].sum()
        elapsed = 0.0
        for piece in self._pieces(path):
            self._place(w)
            self._stepper.measure(piece.t[0], piece.u[0], w.xs, w.ps, w.ys)
            e = begin + elapsed * slope - w.ys[:, 0]
            self._stepper.propagate(piece, w.xs, w.ps)
            self._adapt(w, e, piece.dt[0])
            elapsed += piece.dt[0]
        self._innovate(now)

    def _pieces(self, path: Path) -> list[Path]:
        """Return the path in pieces of one integration step each."""
        if path.pieces == 1 and path.steps[0] == 1:
            return [path]
        pieces, one = [], np.ones(1, dtype=np.int64)
        for k in range(path.pieces):
            h = path.dt[k] / path.steps[k]
            for i in range(path.steps[k]):
                u = path.u[k] + np.array([[i], [i + 1]]) * h * path.slope[k]
                t = path.t[k] + h * np.array([i, i + 1.0])
                pieces.append(Path(1, t, np.full(1, h), one, u, path.slope[k : k + 1].copy()))
        return pieces

    def _innovate(self, now: Instant) -> None:
        w = self.workspace
        self._place(w)
        self._stepper.measure(now.t, now.u, w.xs, w.ps, w.ys)
        self.innovation[:] = now.y - w.ys[:, 0]
        if w.filtered:
            self.figures['excitation'] = float(np.linalg.norm(w.C @ w.U))
            self.figures['covariance'] = float(w.P.diagonal().max())


def _given(name: str, values: tuple[float, ...]) -> tuple[float, ...]:
    """Return the numbers of a setting, none where it is not set."""
    missing = sum(math.isnan(value) for value in values)
    if 0 < missing < len(values):
        raise ValueError(f'give all entries of {name}, or leave it out: {missing} are nan')
    return () if missing else values


def _sizes(given: tuple[float, ...], own: Array) -> Array:
    """Return the scale (a,) of each parameter that is adapted."""
    sizes = _given('scale', given)
    if sizes and len(sizes) not in (1, own.size):
        raise ValueError(f'give scale 1 or {own.size} entries, not {len(sizes)}')
    return np.array(np.broadcast_to(np.array(sizes) if sizes else own, own.shape))
