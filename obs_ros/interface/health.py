"""Health of an estimator: one level and one sentence out of all that may be wrong."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from obs_ros.core.estimate import Outcome
from obs_ros.interface.figures import figures
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.progress import Progress
from obs_ros.interface.status import Health, Level, SubscriptionStatus

STALE = {'output': Outcome.STALE_OUTPUT, 'input': Outcome.STALE_INPUT}
# A confirmed fit at a bound is no alarm: many bounds are physical.
LEVELS = {
    Outcome.CONVERGED: Level.OK,
    Outcome.APPROXIMATE: Level.OK,
    Outcome.AT_BOUND: Level.OK,
    Outcome.DIVERGED: Level.ERROR,
}


@dataclass(frozen=True)
class HealthSettings:
    """Limits beyond which something is said to be wrong."""

    most_useless: float = 0.4  # of all messages: nearly all of one stream, of two alike
    behind: float = 1.0  # s that samples wait unread; less is a hiccup
    apart: float = 0.1  # of the window, from which on one topic is said to wait for another


class Verdict(NamedTuple):
    """Level and sentence, with the outcome that the diagnostics show."""

    level: Level
    message: str
    outcome: str


def examine(
    progress: Progress,
    subscriptions: Mapping[str, SubscriptionStatus],
    settings: Mapping[str, Any],
    counts: Mapping[str, int],
    last_break: str | None,
    forecast: Forecast | None = None,
) -> Health:
    """Return the worst that is known, and every figure.

    `settings` are the node's parameters, `counts` what the observer has dropped or mended.
    """
    level, message, outcome = _Situation(progress, subscriptions, settings, counts).verdict()
    found = figures(progress, subscriptions, settings, counts, last_break, forecast)
    return Health(level, message, {'outcome': outcome, **dict(found)})


def not_configured(state: str, trouble: str) -> Health:
    """Return the health of a managed node in a state in which it has nothing to examine.

    `trouble` is why its last transition did not succeed; empty when it did.
    """
    if trouble:
        return Health(Level.ERROR, f'{state}: {trouble}', {'outcome': state})
    remedy = 'start it anew' if state == 'finalized' else 'call change_state with configure'
    return Health(Level.WARN, f'{state}: {remedy} to go on', {'outcome': state})


@dataclass(frozen=True)
class _Situation:
    """All that a verdict is made of."""

    progress: Progress
    subscriptions: Mapping[str, SubscriptionStatus]
    settings: Mapping[str, Any]
    counts: Mapping[str, int]
    limits: HealthSettings = HealthSettings()

    def verdict(self) -> Verdict:
        """Return the first that holds: what keeps estimates from coming, then the estimate."""
        for check in (
            self._inactive, self._halted, self._unheard, self._behind, self._stale, self._mixed,
            self._unsolved,
        ):  # fmt: skip
            if (found := check()) is not None:
                return found
        return self._estimated()

    @property
    def window(self) -> float | None:
        """Length of a window in s; None for observers that go sample by sample."""
        duration: float | None = self.settings.get('window.duration')
        return duration

    def _inactive(self) -> Verdict | None:
        progress = self.progress
        if progress.active:
            return None
        if progress.error:
            return Verdict(
                Level.ERROR, f'inactive; the observer failed: {progress.error}', 'inactive'
            )
        doing = '' if progress.ready else '; compiling the model'
        message = f'inactive: call change_state with activate to go on{doing}'
        return Verdict(Level.WARN, message, 'inactive')

    def _halted(self) -> Verdict | None:
        progress = self.progress
        if not progress.enabled:
            return Verdict(Level.WARN, 'paused: call ~/enable with true to go on', 'paused')
        if progress.error:
            return Verdict(Level.ERROR, f'the observer failed: {progress.error}', 'failed')
        if not progress.ready:
            message = 'compiling the model; the first time it takes several seconds'
            return Verdict(Level.WARN, message, 'compiling')
        return None

    def _unheard(self) -> Verdict | None:
        for status in self.subscriptions.values():
            if status.silence is None:
                message = f'waiting for {status.topic}: {_why_unheard(status)}'
                return Verdict(Level.WARN, message, 'waiting')
        return None

    def _behind(self) -> Verdict | None:
        after, behind = self.settings['stale_after'], self.progress.behind
        heard = any((status.silence or 0.0) <= after for status in self.subscriptions.values())
        if behind <= self.limits.behind or not heard:
            return None
        return Verdict(
            Level.WARN,
            f'{behind:.1f} s behind: this machine is too slow for observer '
            f'{self.settings["observer"]} at such rates; '
            'publish less often, or take a cheaper observer',
            'behind',
        )

    def _stale(self) -> Verdict | None:
        after = self.settings['stale_after']
        for status in self.subscriptions.values():
            if (status.silence or 0.0) > after:
                outcome = STALE[status.role].value
                message = f'{outcome}: {_why_stale(status, after)}'
                return Verdict(Level.STALE, message, outcome)
        return None

    def _mixed(self) -> Verdict | None:
        for status in self.subscriptions.values():
            if status.alternating:
                return Verdict(
                    Level.WARN,
                    f'mixed: stop all but one of the {status.publishers} publishers of '
                    f'{status.topic}: they take turns, so their samples mix, and estimates are '
                    'withheld',
                    'mixed',
                )
        return None

    def _unsolved(self) -> Verdict | None:
        """Return the verdict before the first estimate."""
        if self.progress.estimate is not None:
            return None
        if obstacle := self._obstacle():
            return Verdict(Level.WARN, obstacle, 'collecting')
        message = 'solving the first window' if self.progress.solving else self._collecting()
        return Verdict(Level.OK, message, 'collecting')

    def _obstacle(self) -> str:
        """Say what keeps the first window from ever closing, if anything does."""
        if self.window is not None:
            seconds, ahead, behind = self._apart()
            if seconds > self.window:
                return (
                    f'use one clock for both publishers: {ahead} is stamped {seconds:.6g} s '
                    f'after {behind}'
                )
            if self.counts.get('overflow', 0):
                return (
                    'shorten window.duration, or raise window.capacity: '
                    f'a window of {self.window:g} s holds more samples than that'
                )
        received = sum(status.received for status in self.subscriptions.values())
        most = self.limits.most_useless * received
        if self.counts.get('duplicate', 0) > most:
            return 'let the publisher set header.stamp: stamps do not advance'
        if self.counts.get('all_nan', 0) > most:
            return 'look at what is measured: the samples hold no numbers, only NaN or infinity'
        if self.counts.get('off_grid', 0) > most:
            return (
                "look at stamps and rates: most samples lie between the nodes of the model's "
                'period, where outputs do not count'
            )
        return ''

    def _collecting(self) -> str:
        """Say how much of the first window is there, and which topic it waits for."""
        waiting, collected = 'waiting for an output with every input known', self.progress.collected
        if self.window is None:
            return waiting
        message = f'collecting the first window: {collected or 0.0:.3g} of {self.window:g} s'
        seconds, ahead, behind = self._apart()
        if seconds > self.limits.apart * self.window:
            return f'{message}; {behind} is {seconds:.3g} s behind {ahead}'
        return f'{message}; {waiting}' if collected is None else message

    def _apart(self) -> tuple[float, str, str]:
        """Return how far (s) stamps of topics differ at most, and which is ahead of which."""
        stamped = [(s.stamp, s.topic) for s in self.subscriptions.values() if s.stamp is not None]
        if len(stamped) < 2:
            return 0.0, '', ''
        (first, behind), (last, ahead) = min(stamped), max(stamped)
        return (last - first) / 1e9, ahead, behind

    def _estimated(self) -> Verdict:
        """Return the verdict on the newest estimate."""
        estimate = self.progress.estimate
        assert estimate is not None
        level = LEVELS.get(estimate.outcome, Level.WARN)
        withheld = '' if estimate.usable else ' (withheld: not finite)'
        message = f'{estimate.outcome.value}{withheld}: {estimate.message}'
        late, unsaved = self.progress.late, self.progress.unsaved
        remarks = [f'raise merge_wait: {late} samples came late just now'] if late else []
        remarks += [unsaved] if unsaved else []
        if remarks and level is Level.OK:
            level, message = Level.WARN, '; '.join([*remarks, message])
        return Verdict(level, message, estimate.outcome.value)


def _why_unheard(status: SubscriptionStatus) -> str:
    """Say why nothing came of a topic yet, and what to do about it."""
    if status.unheard:
        return status.unheard
    if status.last_refusal:
        return f'its messages are refused: {status.last_refusal}'
    if status.publishers:
        return 'its publisher has sent nothing yet'
    return 'start its publisher, or look at the name: nobody publishes it'


def _why_stale(status: SubscriptionStatus, stale_after: float) -> str:
    if status.unheard:
        return status.unheard
    if status.refuses:
        return f'its messages are refused: {status.last_refusal}'
    return f'does a publisher run? no {status.topic} for more than {stale_after:g} s'
