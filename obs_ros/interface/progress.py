"""Progress of an estimator: its counts, its newest estimate, and what keeps it from the next."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from obs_ros.core.estimate import Estimate, Jump
from obs_ros.core.texts import quoted
from obs_ros.interface.worker import Finished


@dataclass
class Progress:
    """Counts and moments of an estimator; times in s."""

    enabled: bool = True
    active: bool = True  # it listens
    ready: bool = False
    compiled: bool = False  # what only some windows need too
    compile_time: float = 0.0
    estimate: Estimate | None = None  # the last one; None after a reset
    latency: float = 0.0
    behind: float = 0.0  # longest time from arrival to absorption since the last examination
    late: int = 0  # samples that came too late within the last `late_for` examinations
    late_for: int = 10  # one a second: long enough for the warning to be read
    error: str = ''  # of the last solve; empty when it went well
    published: int = 0
    too_early: int = 0  # samples that came before an immediate observer was compiled
    withheld: int = 0
    failed: int = 0
    jumps: int = 0
    jump: Jump | None = None  # the last one, as the newest window that holds it says
    retractions: int = 0
    retraction: Jump | None = None  # the last one
    outlier: str = ''  # the last one, in words
    collected: float | None = None  # s of the window that is open; None before its first output
    solving: bool = False  # a window is closed, and its estimate under way
    checkpoint: Mapping[str, object] = field(default_factory=dict)  # figures of its file
    unsaved: str = ''  # why it could not be written last, with a remedy

    def __post_init__(self) -> None:
        # All that were late until each of the last calls.
        self._late: deque[int] = deque([0], maxlen=self.late_for + 1)
        self._lag = 0.0
        self._announced: Jump | None = None  # the last one, as it was announced

    def note_lag(self, seconds: float) -> None:
        """Note how long a sample waited to be absorbed."""
        self._lag = max(self._lag, seconds)
        self.behind = max(self.behind, seconds)

    def begin_examination(self, late: int) -> None:
        """Turn to the time since the last one; so many samples were late since construction."""
        self._late.append(late)
        self.late = self._late[-1] - self._late[0]
        self.behind, self._lag = self._lag, 0.0

    def restart(self) -> None:
        """Begin with a new observer."""
        self.ready = self.compiled = False
        self.estimate, self.error = None, ''

    def conclude(self, estimate: Estimate, latency: float, published: bool) -> None:
        """Note an estimate, and whether it was fit to be published."""
        self.estimate, self.latency, self.error = estimate, latency, ''
        self.published += published
        self.withheld += not published
        self.outlier = estimate.last_outlier or self.outlier
        for jump in estimate.jumps:
            self._note(jump)

    def _note(self, jump: Jump) -> None:
        """Note a jump that a window shows, or takes back."""
        if not jump.retracted:
            self.jumps += jump.new
            self.jump = jump
            self._announced = jump if jump.new else self._announced
            return
        self.retractions += jump.new
        self.retraction = jump
        if self._announced is not None and jump.takes_back(self._announced):
            self.jump = self._announced = None

    def fail(self, finished: Finished) -> None:
        """Note an exception of the observer."""
        self.failed += 1
        self.error = quoted(finished.error)
