"""The state now: an estimate of some time ago, propagated to the newest output."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model, names
from obs_ros.core.record import Sample
from obs_ros.core.typing import AnyArray
from obs_ros.integration.backends import Backend
from obs_ros.integration.path import LANES, Path
from obs_ros.integration.stepper import stepper_for
from obs_ros.samples.gate import DEFAULT as GATE
from obs_ros.samples.gate import GateSettings
from obs_ros.samples.successive_outputs import SuccessiveOutputs


@dataclass(frozen=True)
class PredictionSettings:
    """The memory of a prediction, in intervals from one output to the next."""

    kept: int = 20000  # that an estimate may be late; 20 s at 1000 Hz
    at_once: int = 1000  # that wait to be integrated where nobody asks; some ms


DEFAULT = PredictionSettings()


class Interval(NamedTuple):
    """The inputs of the plant from one output, at `begin` (ns), to the next, at `end`."""

    begin: int
    end: int
    path: Path


class Prediction:
    """Integrates the model from the newest estimate on, under the inputs that came since.

    x (n,) at the estimate's stamp, p (q,) its parameters: x' = f(t, x, u, p) to the newest output,
    which itself is not used. Inputs do as their Variable says, and hold their last value. Without
    a usable estimate there is no prediction; nor does one last beyond a value that is not finite.

    Samples enter by the rules of `Gate`; `limit` sets the limits that the observer has.
    One thread calls everything but `prepare`, which compiles and is for any.
    """

    def __init__(
        self,
        model: Model,
        backend: Backend | None = None,
        gate: GateSettings = GATE,
        settings: PredictionSettings = DEFAULT,
    ) -> None:
        self.model = model
        self.diverged = 0
        self._backend = backend
        self._samples = SuccessiveOutputs(model, gate)
        self._names = names(model.states)
        self._x = np.empty((len(model.states), LANES))
        self._p = np.empty((len(model.parameters), LANES))
        self._trail: deque[Interval] = deque(maxlen=settings.kept)  # for estimates to come
        self._rest: list[Path] = []  # along which x is to be propagated
        self._at_once = settings.at_once
        self._newest: int | None = None
        self.since: int | None = None  # stamp of the estimate

    def prepare(self) -> None:
        """Compile the model's steps, unless they are; may take some seconds."""
        stepper_for(self.model, self._backend)

    def limit(self, gate: GateSettings) -> None:
        """Let samples enter by other limits from now on."""
        self._samples.gate.limit(gate)

    def forget(self) -> None:
        """Forget all samples and the estimate."""
        self._samples.reset()
        self._forget()

    def end(self) -> None:
        """Forget the estimate: there is no prediction until the next one."""
        self.since = None
        self._rest.clear()

    def absorb(self, sample: Sample) -> int | None:
        """Take a sample; return the stamp (ns) of the output that can be predicted to, if any."""
        if self._samples.push(sample):
            self._forget()
        outputs = self._samples.due
        for stamp, _ in outputs:
            if self._newest is not None:
                path = self._samples.inputs.path(self._newest, stamp)
                interval = Interval(self._newest, stamp, own(path))
                self._trail.append(interval)
                if self.since is not None:
                    self._rest.append(interval.path)
            self._newest = stamp
        if len(self._rest) >= self._at_once:
            self._propagate()
        return self._newest if outputs and self.since is not None else None

    def start(self, estimate: Estimate) -> None:
        """Go on from an estimate; from one that is not usable, no more."""
        self.end()
        stamp = estimate.stamp
        if stamp is None or self._newest is None or not estimate.usable:
            return
        while self._trail and self._trail[0].end <= stamp:
            self._trail.popleft()
        if stamp < (self._trail[0].begin if self._trail else self._newest):
            return  # the inputs since then are not known any more
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
            self.end()
            return None
        return dict(zip(self._names, x, strict=True))

    def _propagate(self) -> None:
        if self._rest:
            stepper_for(self.model, self._backend).propagate(joined(self._rest), self._x, self._p)
            self._rest.clear()

    def _forget(self) -> None:
        self.end()
        self._trail.clear()
        self._newest = None


def own(path: Path) -> Path:
    """Return a copy of a path that the next one does not overwrite, without unused rows."""
    return mapped(path.pieces, lambda array: array[: path.pieces + 1].copy(), path)


def cut(interval: Interval, stamp: int) -> Path:
    """Return the rest of an interval's path after `stamp` (ns), which lies before its end."""
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
