"""The observers, by name, and what they have in common."""

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.core.record import Sample
from obs_ros.core.registry import lookup
from obs_ros.core.texts import quoted

PAPERS = 'obs_ros.observers.papers'
OBSERVERS = {
    'sliding_window': 'obs_ros.observers.sliding_window:SlidingWindowObserver',
    'gao': f'{PAPERS}.gao:GeneticAdaptiveObserver',
    'gase': f'{PAPERS}.gase:GeneticAdaptiveStateEstimator',
    'ekf': 'obs_ros.observers.kalman_filters.ekf:ExtendedKalmanObserver',
    'ukf': 'obs_ros.observers.kalman_filters.ukf:UnscentedKalmanObserver',
    'high_gain': f'{PAPERS}.high_gain:HighGainObserver',
    'h_infinity': f'{PAPERS}.h_infinity:HInfinityObserver',
    'interconnected': f'{PAPERS}.interconnected:InterconnectedObserver',
    'unknown_input': f'{PAPERS}.unknown_input:UnknownInputObserver',
    'adaptive_luenberger': f'{PAPERS}.adaptive_luenberger:AdaptiveLuenbergerObserver',
    'rls_luenberger': f'{PAPERS}.rls_luenberger:RecursiveLeastSquaresObserver',
}


class Observer(Protocol):
    """Turns samples into estimates.

    One thread calls `absorb` and `reset`; another may call `estimate` meanwhile. An `immediate`
    one has its estimate ready when `absorb` returns True: then `estimate` is cheap, and is for the
    same thread, after each such sample. One with `takes_priors` takes walks and priors by name. One
    that `remembers` has `identity`, `memory` and `recall` besides, see `Remembering`.
    """

    immediate: ClassVar[bool]
    model: Model

    def prepare(self) -> float:
        """Do what takes long but once, as compiling, for the first estimate; return the seconds."""

    def prepare_more(self) -> bool:
        """Do one more thing that some estimates need, in a second or so; False if nothing is left.

        Results are the same without, but the first estimate that needs it takes longer.
        """

    def absorb(self, sample: Sample) -> bool:
        """Take a sample, without blocking; return whether an estimate is due."""

    def estimate(self, deadline: float | None = None) -> Estimate | None:
        """Return the newest estimate, at most `deadline` s from now; None when nothing is due."""

    def inherit(self, other: Any) -> bool:
        """Take over what is of use from one of its class that it replaces, such as samples.

        Returns whether an estimate is due.
        """

    def reset(self) -> None:
        """Forget all samples and estimates."""

    @property
    def counts(self) -> Mapping[str, int]:
        """Counts of samples dropped, mended or skipped so far, by reason."""

    @property
    def collected(self) -> float | None:
        """Sample time (s) that the window that is open holds; None before its first output.

        None as well where there are no windows.
        """

    @property
    def last_break(self) -> str | None:
        """The last break of the samples' timeline, in words; None if there was none."""


class Remembering(Observer, Protocol):
    """An observer whose knowledge survives a restart."""

    remembers: ClassVar[bool]

    @property
    def identity(self) -> Mapping[str, str]:
        """The settings by name, in words, without which what was learned means something else."""

    @property
    def memory(self) -> Any:
        """All that was learned, frozen data for `to_plain`; None if that is nothing.

        Not for while `estimate` runs; what it returned nothing changes.
        """

    def recall(self, plain: Any) -> None:
        """Go on after the windows of a memory of the same model and settings, before any sample.

        Time since then is a gap. Raises ValueError for what is no such memory; it is as before
        then.
        """


def remembers(observer: type[Observer]) -> bool:
    """Whether what an observer class learns can survive a restart."""
    return getattr(observer, 'remembers', False)


def load_observer(name: str) -> type[Observer]:
    """Return the observer class of that name, or at that `module:ATTRIBUTE`.

    Raises ValueError when there is none, or what stands there cannot observe.
    """
    found = lookup('observer', name, OBSERVERS)
    if not isinstance(found, type) or not hasattr(found, 'absorb'):
        raise ValueError(f'observer {quoted(name)} is {quoted(found)}, not an observer class')
    return found
