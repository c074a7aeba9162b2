"""Forecasts of windows, judged by the measurements that followed them.

A window that noise alone does not explain has several models: its parameters and end state by
process noise, by output error, and those of output error with a filtered end state. The likelihood
of one step ahead only proposes: each model is run on, under the inputs as they come, over an eighth
of a window and over a whole one, and the least sum over outputs and horizons of log MSE is believed
(prequential comparison; Dawid 1984, J. R. Stat. Soc. A 147, 278-292).
"""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from obs_ros.core.interpolation import values_from
from obs_ros.core.model import Interpolation
from obs_ros.core.periods import shortest
from obs_ros.core.record import Record
from obs_ros.core.typing import Array
from obs_ros.inference.assessment.skill import mean_log_errors, skill_of
from obs_ros.integration.backends import Kernels
from obs_ros.integration.grid import Grid


class Basis(StrEnum):
    """The model that a window's estimate is taken from."""

    PROCESS_NOISE = 'process noise'
    FILTERED = 'output error, its state filtered'
    OUTPUT_ERROR = 'output error'


BASES = tuple(Basis)


class Ends(NamedTuple):
    """State (n,) and parameters (q,) at the end of a window."""

    state: Array
    parameters: Array


@dataclass(frozen=True)
class ForecastSettings:
    """Limits in comparing forecasts.

    - `horizons`: windows ahead; the state matters in the first, of which the skill is told, the
      parameters in the last;
    - `remembered`: forecasts that are compared, of each horizon;
    - `enough`: forecasts that must have been compared before they count;
    - `gain`, `deviations`: by which log MSE must be less, on average over outputs and horizons, and
      so many standard deviations of that mean besides, for a change;
    - `steady`: windows from one change of the model to the next;
    - `pending`: forecasts in one window at most: they begin so far apart;
    - `bridged`: samples from one window to the next over which inputs are held.
    """

    horizons: tuple[float, ...] = (1.0 / 8.0, 1.0)
    remembered: int = 20
    enough: int = 4
    gain: float = 0.1
    deviations: float = 2.0
    steady: int = 5
    pending: int = 8
    bridged: float = 3.0


FORECASTS = ForecastSettings()


@dataclass(eq=False)
class Pending:
    """A forecast under way: sums of squared errors (H, B, r), of holding (H, r), counts (H, r)."""

    begin: float
    duration: float
    held: Array
    noise: Array
    model: Array
    hold: Array
    count: Array
    judged: list[bool]

    def copy(self) -> 'Pending':
        """Return one that does not change with this."""
        sums = self.model.copy(), self.hold.copy(), self.count.copy()
        return Pending(self.begin, self.duration, self.held, self.noise, *sums, [*self.judged])


@dataclass(frozen=True)
class Judged:
    """A forecast over one horizon beside the measurements: see `Pending`."""

    begin: float
    duration: float
    model: Array  # (B, r)
    hold: Array  # (r,)
    count: Array  # (r,)
    noise: Array  # (r,)

    @cached_property
    def logs(self) -> Array:
        """Mean log MSE (B,) over outputs, see `mean_log_errors`."""
        return mean_log_errors(self.model, self.hold, self.count, self.noise)


@dataclass(frozen=True)
class ForecastMemory:
    """The forecasts under way at a `time` (s), those judged, by horizon; see `Forecasts`."""

    basis: Basis
    begun: bool
    time: float
    lanes: tuple[Ends, ...]
    pending: tuple[Pending, ...]
    judged: tuple[tuple[Judged, ...], ...]
    since: int


@dataclass(eq=False)
class Forecasts:
    """The forecasts under way, those judged, and the model that they speak for."""

    settings: ForecastSettings = FORECASTS
    basis: Basis = Basis.PROCESS_NOISE
    begun: bool = False
    _time: float = np.nan  # s, to which those under way have come
    _lanes: list[Ends] = field(default_factory=list)  # len(BASES) for each
    _pending: list[Pending] = field(default_factory=list)
    _judged: list[deque[Judged]] = field(default_factory=list)
    _since: int = 0  # windows since the last change of the basis

    def __post_init__(self) -> None:
        remembered = self.settings.remembered
        self._judged = [deque(maxlen=remembered) for _ in self.settings.horizons]

    @property
    def memory(self) -> ForecastMemory:
        """All that is known; nothing changes it later."""
        return ForecastMemory(
            self.basis, self.begun, self._time, tuple(self._lanes),
            tuple(map(Pending.copy, self._pending)), tuple(map(tuple, self._judged)), self._since,
        )  # fmt: skip

    def recall(self, memory: ForecastMemory) -> None:
        """Go on with the forecasts of another one, of the same model."""
        self.basis, self.begun, self._time = memory.basis, memory.begun, memory.time
        self._lanes, self._pending = list(memory.lanes), [*map(Pending.copy, memory.pending)]
        for known, told in zip(self._judged, memory.judged, strict=True):
            known.clear()
            known.extend(told)
        self._since = memory.since

    def advance(self, kernels: Kernels, record: Record) -> None:
        """Run the forecasts on to the end of a record."""
        if not self._pending:
            return
        part = self._since_then(record, [each.interpolation for each in kernels.model.inputs])
        if part is None:
            return
        grid = Grid.of(kernels.model, part, np.ones(part.y.shape[1]), float(record.t[0]))
        x, p = (np.array(rows).T for rows in zip(*self._lanes, strict=True))
        states, outputs = kernels.trajectories(grid, x, p)
        ends = [Ends(x, p) for x, p in zip(states[-1].T, p.T, strict=True)]
        size = len(BASES)
        left = []
        for k, pending in enumerate(self._pending):
            lanes = slice(size * k, size * (k + 1))
            self._compare(pending, grid, outputs[1:, :, lanes])
            if not all(pending.judged):
                left.append((pending, ends[lanes]))
        self._time = float(part.t[-1])
        self._pending = [pending for pending, _ in left]
        self._lanes = [end for _, three in left for end in three]

    def begin(
        self, ends: Mapping[Basis, Ends], time: float, duration: float, held: Array, noise: Array
    ) -> None:
        """Begin forecasts at the end of a window (s); `held` (r,) are its last measured values.

        `noise` (r,) is that below which holding cannot come. A basis that is missing stands for the
        best that there is.
        """
        newest = max((one.begin for one in self._pending), default=-np.inf)
        if self._pending and self._time != time:
            self._drop()
        if time - newest < duration / self.settings.pending:
            return
        self.begun = True
        best = ends.get(Basis.PROCESS_NOISE) or ends[Basis.OUTPUT_ERROR]
        shape = (len(self.settings.horizons), held.size)
        self._time = time
        self._lanes += [ends.get(basis, best) for basis in BASES]
        self._pending.append(Pending(
            time, duration, held, noise,
            np.zeros((shape[0], len(BASES), shape[1])), np.zeros(shape), np.zeros(shape),
            [False] * shape[0],
        ))  # fmt: skip

    def decide(self) -> Basis:
        """Return the basis that forecasts speak for: it changes seldom, for a clear gain only."""
        self._since += 1
        if min(map(len, self._judged)) < self.settings.enough:
            return self.basis
        if self._since > self.settings.steady:
            gains = {basis: self._gain(basis) for basis in BASES if basis is not self.basis}
            best = max(gains, key=gains.__getitem__)
            if gains[best] > self.settings.gain:
                self.basis, self._since = best, 0
        return self.basis

    def skill(self) -> float | None:
        """Return the skill of the basis over the first horizon; None before there are enough."""
        judged = self._judged[0]
        if len(judged) < self.settings.enough:
            return None
        model = sum_of(judged, 'model')[BASES.index(self.basis)]
        return skill_of(model, sum_of(judged, 'hold'), sum_of(judged, 'count'), noise_of(judged))

    def _gain(self, basis: Basis) -> float:
        """Return the mean log MSE that a basis saves, less `deviations` of that mean."""
        saved = [
            one.logs[BASES.index(self.basis)] - one.logs[BASES.index(basis)]
            for judged in self._judged for one in judged
        ]  # fmt: skip
        # As many are independent as do not overlap.
        newest = self._judged[-1]
        apart = 1.0 + (newest[-1].begin - newest[0].begin) / newest[-1].duration
        sure = np.std(saved) / np.sqrt(max(1.0, min(apart, len(newest))))
        return float(np.mean(saved) - self.settings.deviations * sure)

    def _since_then(self, record: Record, kinds: Sequence[Interpolation]) -> Record | None:
        """Return the record from where forecasts have come, to its last output; None if nothing.

        Forecasts across more than some samples that no record covers are dropped.
        """
        t, last = record.t, int(np.flatnonzero(np.isfinite(record.y).any(axis=1))[-1])
        first = int(np.searchsorted(t, self._time, side='right')) - 1
        interval = float(t[-1] - t[0]) / max(1, t.size - 1)
        if first < 0 and t[0] - self._time > self.settings.bridged * interval:
            self._drop()
            return None
        if self._time >= t[last]:
            return None
        rest = slice(max(first, 0) + (first >= 0), last + 1)
        return Record(
            np.append(self._time, t[rest]),
            np.vstack([values_from(record.t, record.u, kinds, self._time), record.u[rest]]),
            np.vstack([np.full((1, record.y.shape[1]), np.nan), record.y[rest]]),
        )

    def _compare(self, pending: Pending, grid: Grid, outputs: Array) -> None:
        """Add the errors of outputs (K - 1, r, B) to those of a forecast."""
        t, y, known = grid.t[1:], grid.y[1:], grid.weight[1:] > 0.0
        outputs = outputs if grid.ends is None else grid.ends[1:].shown(outputs)
        known = known & np.isfinite(pending.held)
        held = np.where(np.isfinite(pending.held), pending.held, 0.0)
        errors = shortest(outputs - y[:, :, None], grid.period[:, None])
        squares = np.where(known[:, :, None], errors**2, 0.0)
        holding = np.where(known, shortest(held - y, grid.period) ** 2, 0.0)
        for h, horizon in enumerate(self.settings.horizons):
            if pending.judged[h]:
                continue
            end = pending.begin + horizon * pending.duration
            upto = int(np.searchsorted(t, end, side='right'))
            pending.model[h] += squares[:upto].sum(axis=0).T
            pending.hold[h] += holding[:upto].sum(axis=0)
            pending.count[h] += known[:upto].sum(axis=0)
            if t[-1] >= end:
                pending.judged[h] = True
                self._judged[h].append(Judged(
                    pending.begin, pending.duration, pending.model[h], pending.hold[h],
                    pending.count[h], pending.noise,
                ))  # fmt: skip

    def _drop(self) -> None:
        self._pending, self._lanes = [], []


def sum_of(judged: deque[Judged], name: str) -> Array:
    """Return the sum of one of the arrays over forecasts."""
    return np.asarray(np.sum([getattr(one, name) for one in judged], axis=0))


def noise_of(judged: deque[Judged]) -> Array:
    """Return the median noise (r,) below which holding cannot come."""
    return np.asarray(np.median([one.noise for one in judged], axis=0))
