"""Windows of a stream, solved one after the other (Yang, Li & Dahhou 2020, section 4.4)."""

import logging
import threading
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from obs_ros.core.deadline import Deadline
from obs_ros.core.estimate import Estimate
from obs_ros.core.jit import at_once
from obs_ros.core.model import Model, names
from obs_ros.core.record import Record, Sample
from obs_ros.core.rng import random_generator
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import EstimationSettings
from obs_ros.horizon.solver import Solver
from obs_ros.inference.assessment.structural import confounded
from obs_ros.inference.outlier_count import OutlierCount
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.models import load_model
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.range_check import limits
from obs_ros.samples.window import SlidingWindow

END = object()

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
        self._due: Record | None = None
        self._windows = self._begin()
        self._solved = 0
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
            self._due = record
        return True

    def estimate(self, deadline: float | None = None) -> Estimate | None:
        """Solve the newest closed window within `deadline` s (None: until it is accepted).

        None if no window is due, or if everything was reset meanwhile.
        """
        with self._lock:
            record, self._due = self._due, None
            windows, epoch = self._windows, self._epoch
            rng = random_generator(self._seed, self._solved)
        if record is None:
            return None
        before = windows.stuck, windows.huge, windows.outliers.counts
        estimate = windows.solve(record, rng, Deadline(deadline))
        self._stuck += windows.stuck - before[0]
        self._huge += windows.huge - before[1]
        for reason, count in windows.outliers.counts.items():
            self._outliers[reason] += count - before[2][reason]
        with self._lock:
            if epoch != self._epoch:
                return None
            self._solved += 1
        return estimate

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
