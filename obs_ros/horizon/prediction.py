"""The state now: an estimate of some time ago, carried on to the newest output."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model, names
from obs_ros.core.record import Sample
from obs_ros.core.typing import AnyArray
from obs_ros.integration.backends import Backend
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.samples.gate import Intake

KEPT = 20000  # intervals between outputs that an estimate may be late
MOST = 1000  # intervals that are carried at once


class Interval(NamedTuple):
    """What the plant was fed from one output, at `begin` (ns), to the next, at `end`."""

    begin: int
    end: int
    path: Path


class Prediction:
    """Integrates the model from the newest estimate on, under the inputs that came since.

    x (n,) at the estimate's stamp, p (q,) its parameters: x' = f(t, x, u, p) to the newest output,
    which itself is not used. Inputs do as their Variable says, and hold their last value. Without
    a usable estimate there is no prediction; nor does one last beyond a value that is not finite.

    One thread calls everything but `prepare`, which compiles and is for any.
    """

    def __init__(self, model: Model, backend: Backend | None = None) -> None:
        self.model = model
        self.diverged = 0
        self._backend = backend
        self._intake = Intake(model, 0.0)
        self._names = names(model.states)
        self._x = np.empty((len(model.states), LANES))
        self._p = np.empty((len(model.parameters), LANES))
        self._trail: deque[Interval] = deque(maxlen=KEPT)  # for estimates to come
        self._rest: list[Path] = []  # what x has not been carried along yet
        self._newest: int | None = None
        self.since: int | None = None  # stamp of the estimate

    def prepare(self) -> None:
        """Compile the model's steps, unless they are; may take some seconds."""
        stepper_for(self.model, self._backend)

    def forget(self) -> None:
        """Forget all samples and the estimate."""
        self._intake.reset()
        self._forget()

    def absorb(self, sample: Sample) -> int | None:
        """Take a sample; return the stamp (ns) of the output that can be predicted to, if any."""
        last_break = self._intake.last_break
        outputs = self._intake.push(sample)
        if self._intake.last_break is not last_break:
            self._forget()
        for stamp, _ in outputs:
            if self._newest is not None:
                path = self._intake.inputs.path(self._newest, stamp)
                interval = Interval(self._newest, stamp, own(path))
                self._trail.append(interval)
                if self.since is not None:
                    self._rest.append(interval.path)
            self._newest = stamp
        if len(self._rest) >= MOST:
            self._propagate()
        return self._newest if outputs and self.since is not None else None

    def start(self, estimate: Estimate) -> None:
        """Go on from an estimate; from one that is not usable, no more."""
        stamp, self.since = estimate.stamp, None
        self._rest.clear()
        if stamp is None or self._newest is None or not estimate.usable:
            return
        while self._trail and self._trail[0].end <= stamp:
            self._trail.popleft()
        if stamp < (self._trail[0].begin if self._trail else self._newest):
            return  # what the plant was fed since then is not known any more
        for values, group in ((self._x, estimate.state), (self._p, estimate.parameters)):
            values[:] = np.array(list(group.values())).reshape(-1, 1)
        self.since = stamp
        self._rest += [cut(interval, stamp) for interval in self._trail]

    def state(self) -> dict[str, float] | None:
        """Return the states at the newest output by name; None if there is no prediction."""
        if self.since is None:
            return None
        self._propagate()
        x = self._x[:, 0].tolist()
        if not math.isfinite(sum(x)):
            self.diverged += 1
            self.since = None
            self._rest.clear()
            return None
        return dict(zip(self._names, x, strict=True))

    def _propagate(self) -> None:
        if self._rest:
            stepper_for(self.model, self._backend).propagate(joined(self._rest), self._x, self._p)
            self._rest.clear()

    def _forget(self) -> None:
        self._trail.clear()
        self._rest.clear()
        self._newest = self.since = None


def own(path: Path) -> Path:
    """Return a copy of a path that the next one does not overwrite, without unused rows."""
    return mapped(path.pieces, lambda array: array[: path.pieces + 1].copy(), path)


def cut(interval: Interval, stamp: int) -> Path:
    """Return what is left of an interval's path after `stamp` (ns), which lies before its end."""
    path = own(interval.path)
    if stamp <= interval.begin:
        return path
    gone = (stamp - interval.begin) / 1e9
    ends = np.cumsum(path.dt[: path.pieces])
    k = min(int(np.searchsorted(ends, gone, side='right')), path.pieces - 1)
    s = min(gone - (ends[k] - path.dt[k]), path.dt[k])
    path.t[k] += s
    path.dt[k] -= s
    path.u[k] += s * path.slope[k]
    return mapped(path.pieces - k, lambda array: array[k:].copy(), path)


def joined(paths: Sequence[Path]) -> Path:
    """Return one path from where the first begins to where the last ends; it has no end row."""
    if len(paths) == 1:
        return paths[0]
    counts = [path.pieces for path in paths]

    def chain(*arrays: AnyArray) -> AnyArray:
        return np.concatenate([a[:count] for a, count in zip(arrays, counts, strict=True)])

    return mapped(sum(counts), chain, *paths)


def mapped(pieces: int, function: Callable[..., Any], *paths: Path) -> Path:
    """Return the path whose every array is the function of those of the given paths."""
    return Path(
        pieces, *(function(*arrays) for arrays in zip(*(p[1:] for p in paths), strict=True))
    )
