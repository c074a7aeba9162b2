"""Windows of a stream, solved one after the other (Yang, Li & Dahhou 2020, section 4.4)."""

import logging
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate
from obs_ros.core.jit import at_once
from obs_ros.core.model import Model, names
from obs_ros.core.plain_data import from_plain
from obs_ros.core.record import Record, Sample
from obs_ros.core.rng import random_generator
from obs_ros.horizon.horizon_memory import HorizonMemory
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.structural import confounded
from obs_ros.inference.outlier_count import OutlierCount
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models import load_model
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.range_check import limits
from obs_ros.samples.stream import STAMP_LIMIT
from obs_ros.samples.window import SlidingWindow

END = object()


@dataclass(frozen=True)
class WindowsMemory:
    """What windows have learned, with the number solved so far and the last one's end (ns)."""

    end: int
    solved: int
    horizon: HorizonMemory


log = logging.getLogger(__name__)


class SlidingWindowObserver:
    """Estimates each window of `duration` s, one every `period` s of sample time.

    Successive windows inherit what earlier ones have learned, and jumps inside a window are found;
    see `MovingHorizon`. With `learn_noise` the noise that is given is only a starting value. Of
    windows that close before `estimate` is called, only the newest is kept; the others are
    counted as `skipped`. `capacity` bounds the samples kept of each stream; `settings` are those of
    `EstimationSettings`.

    Raises ValueError for settings that are wrong, with the name and the value.
    """

    immediate: ClassVar[bool] = False
    takes_priors: ClassVar[bool] = True
    remembers: ClassVar[bool] = True

    def __init__(
        self,
        model: Model | str,
        *,
        duration: float,
        period: float | None = None,
        capacity: int = 20000,
        seed: int = 0,
        learn_noise: bool = False,
        **settings: Any,
    ) -> None:
        self._solver = Solver.of(load_model(model), EstimationSettings(**settings))
        self.model = self._solver.model
        self._rehearsed = self._solver.rehearsed()
        self._learn_noise = learn_noise
        self._window = SlidingWindow(
            duration,
            period,
            n_inputs=len(self.model.inputs),
            n_outputs=len(self.model.outputs),
            capacity=capacity,
            interpolation=[variable.interpolation for variable in self.model.inputs],
            limits=(limits(self.model, self.model.inputs), limits(self.model, self.model.outputs)),
            outputs=self.model.outputs,
            shifts=Shifts.of(self.model),
            nodes=self.model.period,
        )
        self._geometry = duration, period, capacity
        random_generator(seed)  # refuses a bad one now
        self._seed = seed
        self._skipped = 0
        self._stuck, self._huge = 0, 0  # values
        self._outliers = OutlierCount(names(self.model.outputs)).counts
        # Shared by the thread that absorbs and the one that estimates.
        self._lock = threading.Lock()
        self._due: tuple[Record, int] | None = None  # with the end (ns) of its window
        self._windows = self._begin()
        self._solved, self._end = 0, 0  # windows solved, and the end (ns) of the last one
        self._epoch = 0  # counts resets: what was begun before one is dropped after it

    @property
    def unknowns(self) -> Unknowns:
        """The states and parameters that are estimated."""
        return self._solver.unknowns

    def prepare(self) -> float:
        """Compile what every window needs, unless it is; return the seconds that it took.

        Parameters that no input can tell apart are looked for, and told in the log.
        """
        seconds = self._solver.prepare(process_noise=False)
        for each in confounded(self._solver.kernels, self.unknowns, self._geometry[0]):
            log.warning('model %r: %s', self.model.name, each)
        return seconds

    @np.errstate(all='ignore')
    def prepare_more(self) -> bool:
        """See `Observer.prepare_more`."""
        with at_once():
            return next(self._rehearsed, END) is not END

    def absorb(self, sample: Sample) -> bool:
        """Store a sample; return whether it closed a window. Never blocks for long."""
        if self._window.push(sample):
            self._forget()
        record = self._window.take_newest()
        if record is None:
            return False
        with self._lock:
            self._skipped += self._due is not None
            self._due = record, self._window.last_end or 0
        return True

    def estimate(self, deadline: float | None = None) -> Estimate | None:
        """Solve the newest closed window within `deadline` s (None: until it is accepted).

        None if no window is due, or if everything was reset meanwhile.
        """
        with self._lock:
            due, self._due = self._due, None
            windows, epoch = self._windows, self._epoch
            rng = random_generator(self._seed, self._solved)
        if due is None:
            return None
        record, end = due
        before = windows.stuck, windows.huge, windows.outliers.counts
        estimate = windows.solve(record, rng, Deadline(deadline))
        self._stuck += windows.stuck - before[0]
        self._huge += windows.huge - before[1]
        for reason, count in windows.outliers.counts.items():
            self._outliers[reason] += count - before[2][reason]
        with self._lock:
            if epoch != self._epoch:
                return None
            self._solved, self._end = self._solved + 1, end
        return estimate

    @property
    def identity(self) -> dict[str, str]:
        """See `Observer.identity`."""
        unknowns, settings, scale = self.unknowns, self._solver.settings, self.unknowns.scale
        found = {'window.duration': repr(float(self._geometry[0]))}
        for name in ('process_noise', 'loss', 'fitness'):
            found[name] = str(getattr(settings, name))
        found['learn_noise'] = repr(bool(self._learn_noise))
        for i, name in enumerate(unknowns.names):
            box = float(scale.lower[i]), float(scale.upper[i]), *unknowns.limits[:, i].tolist()
            found[f'bounds.{name}'] = repr(box)
        for variable, value in zip(self.model.variables, unknowns.given.tolist(), strict=True):
            if variable.name not in unknowns.names:
                found[f'fixed.{variable.name}'] = repr(value)
        return found | {f'noise.{name}': repr(sd) for name, sd in self._solver.noise.items()}

    @property
    def memory(self) -> WindowsMemory | None:
        """See `Observer.memory`."""
        horizon = self._windows.memory if self._solved else None
        return None if horizon is None else WindowsMemory(self._end, self._solved, horizon)

    def recall(self, plain: Any) -> None:
        """See `Observer.recall`."""
        shapes = self._windows.shapes
        memory: WindowsMemory = from_plain(WindowsMemory, plain, shapes)
        if not (memory.solved > 0 and abs(memory.end) < STAMP_LIMIT):
            raise ValueError(f'a window that ended at {memory.end} ns was none')
        windows = self._begin()
        windows.recall(memory.horizon)
        self._windows, self._solved, self._end = windows, memory.solved, memory.end
        self._window.resume(memory.end)

    def inherit(self, other: 'SlidingWindowObserver') -> bool:
        """Go on with the samples and counts of the observer that this one replaces.

        Only where the windows are the same. What the other has learned is left to it. Returns
        whether a window is due.
        """
        if self._geometry != other._geometry:
            return False
        self._window, self._outliers = other._window, other._outliers
        self._stuck, self._huge = other._stuck, other._huge
        with other._lock:
            self._skipped, self._due = other._skipped, other._due
            other._due = None
        return self._due is not None

    def reset(self) -> None:
        """Forget all samples and estimates, but not the counts."""
        self._window.reset()
        self._forget()

    @property
    def counts(self) -> Mapping[str, int]:
        """Counts of samples dropped, mended or skipped so far, by reason."""
        counts = dict(self._window.counts)
        counts['huge'] += self._huge
        counts |= {'stuck': self._stuck, **self._outliers}
        return {**counts, 'skipped': self._skipped + counts['skipped']}

    @property
    def collected(self) -> float | None:
        """Sample time (s) that the window that is open holds; None before its first output."""
        return self._window.collected

    @property
    def last_break(self) -> str | None:
        """The last break of the samples' timeline, in words."""
        return self._window.last_break

    def _begin(self) -> MovingHorizon:
        return MovingHorizon(self._solver, learn_noise=self._learn_noise)

    def _forget(self) -> None:
        with self._lock:
            self._due = None
            self._windows = self._begin()
            self._solved = 0
            self._epoch += 1
