"""How the estimator is doing: one level and one sentence out of all that may be wrong."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from obs_ros.core.estimate import Estimate, Jump, Outcome
from obs_ros.core.kernel_cache import cache_trouble
from obs_ros.core.texts import quoted
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.status import Health, Level
from obs_ros.interface.worker import Finished

MOST = 0.4  # of all messages, in both streams together
BEHIND = 1.0  # s that samples wait unread; less is a hiccup
LATE_FOR = 10  # diagnostics that late samples are told in
LAG = 0.1  # of the window, by which a topic is behind another and has to be waited for
STALE = {'output': Outcome.STALE_OUTPUT, 'input': Outcome.STALE_INPUT}
# A confirmed fit at a bound is no alarm: many bounds are physical.
LEVELS = {
    Outcome.CONVERGED: Level.OK,
    Outcome.AT_BOUND: Level.OK,
    Outcome.DIVERGED: Level.ERROR,
}


class Turns(Protocol):
    """The lost messages of a topic, by their publishers' numbers."""

    lost: int


class Feed(Protocol):
    """How a subscribed topic is doing; see `obs_ros.ros.subscription.Feed`."""

    topic: str
    received: int
    last_refusal: str
    unheard: str  # why a publisher is not heard, if one is not
    stamp: int | None  # of the last right message, ns

    @property
    def role(self) -> str:
        """What it brings, `input` or `output`."""

    @property
    def refused(self) -> Mapping[str, int]:
        """Messages that were refused, by reason."""

    @property
    def turns(self) -> Turns:
        """The publishers' numbers."""

    @property
    def silence(self) -> float | None:
        """Wall time since the last right message in s; None before the first."""

    @property
    def publishers(self) -> int:
        """How many publishers there are."""

    @property
    def mixed(self) -> bool:
        """Whether publishers take turns."""

    @property
    def reliable(self) -> bool:
        """Whether lost messages are sent again."""

    @property
    def refuses(self) -> bool:
        """Whether the last message was refused."""

    def rate(self) -> float:
        """Return the messages per s of wall time since the last call."""


@dataclass
class Progress:
    """Where the estimator stands; times in s."""

    enabled: bool = True
    ready: bool = False
    compile_time: float = 0.0
    estimate: Estimate | None = None  # the last one; None after a reset
    latency: float = 0.0
    behind: float = 0.0  # from the arrival of the newest sample until it was absorbed
    late: int = 0  # samples that came too late within the last LATE_FOR calls of `note_late`
    error: str = ''  # of the last solve; empty when it went well
    published: int = 0
    too_early: int = 0  # samples that came before an immediate observer was compiled
    withheld: int = 0
    failed: int = 0
    jumps: int = 0
    jump: Jump | None = None  # the last one, as the newest window that holds it says
    collected: float | None = None  # s of the window that is open; None before its first output
    solving: bool = False  # a window is closed, and its estimate under way

    def __post_init__(self) -> None:
        self._late: deque[int] = deque([0], maxlen=LATE_FOR + 1)  # all that were late, by calls

    def note_late(self, count: int) -> None:
        """Note how many samples were late since construction."""
        self._late.append(count)
        self.late = self._late[-1] - self._late[0]

    def restart(self) -> None:
        """Begin with a new observer."""
        self.ready, self.estimate, self.error = False, None, ''

    def conclude(self, estimate: Estimate, latency: float, published: bool) -> None:
        """Note an estimate, and whether it was fit to be published."""
        self.estimate, self.latency, self.error = estimate, latency, ''
        self.published += published
        self.jumps += sum(jump.new for jump in estimate.jumps)
        self.jump = estimate.jumps[-1] if estimate.jumps else self.jump
        self.withheld += not published

    def fail(self, finished: Finished) -> None:
        """Note an exception of the observer."""
        self.failed += 1
        self.error = quoted(finished.error)


def examine(
    progress: Progress,
    feeds: Mapping[str, Feed],
    settings: Mapping[str, Any],
    counts: Mapping[str, int],
    last_break: str | None,
    forecast: Forecast | None = None,
) -> Health:
    """Return the worst that is known, and every figure."""
    level, message, outcome = _judge(progress, feeds, settings, counts)
    figures: dict[str, object] = {
        'outcome': outcome,
        'observer': settings['observer'],
        'ready': progress.ready,
        'enabled': progress.enabled,
        'published': progress.published,
        'withheld': progress.withheld,
        'failed': progress.failed,
        'compile_time_s': progress.compile_time,
    }
    if progress.too_early:
        figures['too_early'] = progress.too_early
    if estimate := progress.estimate:
        figures |= {
            'residual_rms': estimate.residual_rms,
            'evaluations': estimate.evaluations,
            'solve_time_s': estimate.solve_time,
            'latency_s': progress.latency,
            'behind_s': progress.behind,
        }
        figures |= {f'residual_rms.{name}': rms for name, rms in estimate.output_rms.items()}
        figures |= {f'weak.{i}': words for i, words in enumerate(estimate.weak, 1)}
        if estimate.advice:
            figures['advice'] = estimate.advice
    figures['jumps'] = progress.jumps
    if progress.jump:
        figures['last_jump'] = str(progress.jump)
        if progress.jump.alternatives:
            figures['last_jump.or'] = '; '.join(progress.jump.alternatives)
    for name, feed in feeds.items():
        figures |= {
            f'{name}.received': feed.received,
            f'{name}.rate_hz': feed.rate(),
            f'{name}.publishers': feed.publishers,
            f'{name}.reliable': feed.reliable,
            f'{name}.lost': feed.turns.lost,
        }
        figures |= {f'{name}.{reason}': count for reason, count in feed.refused.items()}
        if feed.last_refusal:
            figures[f'{name}.last_refusal'] = feed.last_refusal
    figures |= {f'samples.{reason}': n for reason, n in counts.items() if reason != 'skipped'}
    figures['skipped'] = counts.get('skipped', 0)
    if forecast is not None:
        figures |= {'predicted': forecast.published, 'prediction_diverged': forecast.diverged}
        if forecast.horizon is not None:
            figures |= {
                'prediction_horizon_s': forecast.horizon,
                'prediction_latency_s': forecast.latency,
            }
    if trouble := cache_trouble():
        figures['kernel_cache'] = trouble
    if last_break:
        figures['last_break'] = last_break
    return Health(level, message, figures)


def _obstacle(feeds: Mapping[str, Feed], counts: Mapping[str, int], window: float | None) -> str:
    """Say what keeps the first window from ever closing, if anything does."""
    received = sum(feed.received for feed in feeds.values())
    if window is not None:
        seconds, ahead, behind = _apart(feeds)
        if seconds > window:
            return (
                f'use one clock for both publishers: {ahead} is stamped {seconds:.6g} s '
                f'after {behind}'
            )
        if counts.get('overflow', 0):
            return (
                'shorten window.duration, or raise window.capacity: '
                f'a window of {window:g} s holds more samples than that'
            )
    if counts.get('duplicate', 0) > MOST * received:
        return 'let the publisher set header.stamp: stamps do not advance'
    if counts.get('all_nan', 0) > MOST * received:
        return 'look at what is measured: the samples hold no numbers, only NaN or infinity'
    return ''


def _apart(feeds: Mapping[str, Feed]) -> tuple[float, str, str]:
    """Return by how much (s) stamps of topics differ at most, and which is ahead of which."""
    stamped = [(f.stamp, f.topic) for f in feeds.values() if f.stamp is not None]
    if len(stamped) < 2:
        return 0.0, '', ''
    (first, behind), (last, ahead) = min(stamped), max(stamped)
    return (last - first) / 1e9, ahead, behind


def _collecting(feeds: Mapping[str, Feed], window: float | None, collected: float | None) -> str:
    """Say how much of the first window is there, and which topic it waits for."""
    if window is None:
        return 'waiting for an output with every input known'
    message = f'collecting the first window: {collected or 0.0:.3g} of {window:g} s'
    seconds, ahead, behind = _apart(feeds)
    if seconds > LAG * window:
        return f'{message}; {behind} is {seconds:.3g} s behind {ahead}'
    if collected is None:
        return f'{message}; waiting for an output with every input known'
    return message


def _unheard(feed: Feed) -> str:
    """Say why nothing came of a topic yet, and what to do about it."""
    if feed.unheard:
        return feed.unheard
    if feed.last_refusal:
        return f'its messages are refused: {feed.last_refusal}'
    if feed.publishers:
        return 'its publisher has sent nothing yet'
    return 'start its publisher, or look at the name: nobody publishes it'


def _stale(feed: Feed, stale_after: float) -> str:
    if feed.unheard:
        return feed.unheard
    if feed.refuses:
        return f'its messages are refused: {feed.last_refusal}'
    return f'does a publisher run? no {feed.topic} for more than {stale_after:g} s'


def _judge(
    progress: Progress,
    feeds: Mapping[str, Feed],
    settings: Mapping[str, Any],
    counts: Mapping[str, int],
) -> tuple[Level, str, str]:
    """Return level, message and outcome; what keeps estimates from coming stands first."""
    stale_after, window = settings['stale_after'], settings.get('window.duration')
    if not progress.enabled:
        return Level.WARN, 'paused: call ~/enable with true to go on', 'paused'
    if progress.error:
        return Level.ERROR, f'the observer failed: {progress.error}', 'failed'
    if not progress.ready:
        return (
            Level.WARN,
            'compiling the model; the first time it takes several seconds',
            'compiling',
        )
    for feed in feeds.values():
        if feed.silence is None:
            return Level.WARN, f'waiting for {feed.topic}: {_unheard(feed)}', 'waiting'
    heard = any((feed.silence or 0.0) <= stale_after for feed in feeds.values())
    if progress.behind > BEHIND and heard:
        return Level.WARN, (
            f'{progress.behind:.1f} s behind: this machine is too slow for observer '
            f'{settings["observer"]} at such rates; publish less often, or take a cheaper observer'
        ), 'behind'  # fmt: skip
    for feed in feeds.values():
        if (feed.silence or 0.0) > stale_after:
            outcome = STALE[feed.role].value
            return Level.STALE, f'{outcome}: {_stale(feed, stale_after)}', outcome
    for feed in feeds.values():
        if feed.mixed:
            return Level.WARN, (
                f'mixed: stop all but one of the {feed.publishers} publishers of {feed.topic}: '
                'they take turns, so their samples mix, and estimates are withheld'
            ), 'mixed'  # fmt: skip
    if progress.estimate is None:
        if obstacle := _obstacle(feeds, counts, window):
            return Level.WARN, obstacle, 'collecting'
        if progress.solving:
            return Level.OK, 'solving the first window', 'collecting'
        return Level.OK, _collecting(feeds, window, progress.collected), 'collecting'
    outcome = progress.estimate.outcome
    level = LEVELS.get(outcome, Level.WARN)
    withheld = '' if progress.estimate.usable else ' (withheld: not finite)'
    message = f'{outcome.value}{withheld}: {progress.estimate.message}'
    if progress.late and level is Level.OK:
        level = Level.WARN
        message = f'raise merge_wait: {progress.late} samples came late just now; {message}'
    return level, message, outcome.value
