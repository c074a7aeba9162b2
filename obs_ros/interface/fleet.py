"""A fleet in plain numbers: its parameters, the names of its plants, its health. Knows no ROS."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from obs_ros.core.parameter_spec import ParameterSpec
from obs_ros.core.texts import LONGEST_NAME, MOST_LISTED, listing, quoted
from obs_ros.interface.status import Health, Level
from obs_ros.interface.usage import node_usage

MOST_PLANTS = 256  # in one process, so that no remote value fills the memory: 2.5 MB each
_NAMESPACE = re.compile(r'/|(/[A-Za-z_][A-Za-z0-9_]*)+')
NO_PLANTS = ('',)  # ROS takes no empty array for one of texts

FLEET = (
    ParameterSpec('plants', NO_PLANTS,
        f"namespaces of the plants, each with an estimator of its own, {MOST_PLANTS} at most; "
        "['']: none"),
    ParameterSpec('workers', 0, 'threads that solve, for all plants; 0: one for each core',
        lower=0, upper=64, read_only=True),
)  # fmt: skip

OWN = frozenset(spec.name for spec in FLEET)


def plants(names: Sequence[str]) -> tuple[str, ...]:
    """Return the namespaces of the plants that are named.

    Raises ValueError for too many, for one that stands twice, and for what is no full name of a
    namespace.
    """
    if tuple(names) == NO_PLANTS:
        return ()
    if len(names) > MOST_PLANTS:
        raise ValueError(
            f'plants: start a second fleet for some of them: {len(names)} are more than '
            f'{MOST_PLANTS}'
        )
    seen = set()
    for name in names:
        if len(name) > LONGEST_NAME or not _NAMESPACE.fullmatch(name):
            raise ValueError(
                "plants: name each as '/line1/tank_a': letters, digits and _ after every '/', no "
                f'digit first, {LONGEST_NAME} characters at most; not {quoted(name)}'
            )
        if name in seen:
            raise ValueError(f'plants: {quoted(name)} stands twice: take one of them away')
        seen.add(name)
    return tuple(names)


@dataclass(frozen=True)
class FleetSettings:
    """Limits beyond which a fleet says that something is wrong."""

    slow: float = 1.0  # s from the end of a window to its estimate: the deadline of one solve


@dataclass(frozen=True)
class PlantStatus:
    """One plant at one moment: estimates so far, windows skipped so far, and what keeps it.

    `lag` (s of wall time) has passed since the sample that closed the oldest window whose estimate
    is not published; where there is none it is that of the last estimate. `error` is of its last
    solve; empty when that went well.
    """

    estimates: int = 0
    skipped: int = 0
    lag: float = 0.0
    error: str = ''


class FleetHealth:
    """Judges a fleet once a second, by what has changed since."""

    def __init__(self, workers: int, settings: FleetSettings = FleetSettings()) -> None:
        self._workers = workers
        self._settings = settings
        self._before: Mapping[str, PlantStatus] = {}

    def examine(
        self,
        running: Mapping[str, PlantStatus],
        refused: Mapping[str, str],
        twice: Sequence[str],
        seconds: float,
    ) -> Health:
        """Return the worst that is known, and every figure, `seconds` after the last call.

        `refused` says why plants could not be started; those that run `twice` have a namesake in
        another process.
        """
        before, self._before = self._before, dict(running)
        done = sum(
            max(0, now.estimates - before[name].estimates)
            for name, now in running.items()
            if name in before
        )
        skipping = [
            name
            for name, now in running.items()
            if name in before and now.skipped > before[name].skipped
        ]
        slowest = max(running, key=lambda name: running[name].lag, default='')
        lag = running[slowest].lag if slowest else 0.0
        rate = done / max(seconds, 1e-9)
        figures: dict[str, Any] = {
            'plants': len(running),
            'workers': self._workers,
            'estimates_per_second': rate,
            'slowest': slowest,
            'slowest.lag_s': lag,
            'skipped': sum(now.skipped for now in running.values()),
        }
        many: dict[str, Any] = {
            f'skipped.{name}': now.skipped for name, now in running.items() if now.skipped
        }
        many |= {f'refused.{name}': why for name, why in refused.items()}
        figures |= dict(islice(many.items(), MOST_LISTED))
        return Health(*self._verdict(running, refused, twice, skipping, slowest, lag), figures)

    def _verdict(
        self,
        running: Mapping[str, PlantStatus],
        refused: Mapping[str, str],
        twice: Sequence[str],
        skipping: Sequence[str],
        slowest: str,
        lag: float,
    ) -> tuple[Level, str]:
        """Return level and sentence: the first that holds."""
        more = 'give it more workers or a longer window.period, or start a second fleet'
        if refused:
            return (
                Level.ERROR,
                f'not started: {listing(list(refused))}: {next(iter(refused.values()))}',
            )
        if failing := [name for name, now in running.items() if now.error]:
            return Level.ERROR, f'failing: {listing(failing)}: {running[failing[0]].error}'
        if twice:
            return Level.WARN, f'end one of two nodes of the same name: {listing(twice)}'
        if not running:
            return Level.WARN, "no plants: set plants, such as ['/line1/tank_a', '/line1/tank_b']"
        if skipping:
            return Level.WARN, f'windows skipped: {more}: {listing(skipping)}'
        if lag > self._settings.slow:
            return Level.WARN, f'{slowest} is {lag:.2g} s behind: {more}'
        return Level.OK, f'{len(running)} plants, the slowest estimate took {lag:.2g} s'


def usage() -> str:
    """Return what `fleet --help` prints."""
    return node_usage(
        'fleet',
        'Estimates the states and parameters of many plants in one process: for each of `plants` a '
        'node NAMESPACE/estimator with the topics, parameters and services of `estimator`.',
        FLEET,
        {
            'any parameter of estimator': 'holds for every plant',
            'NAMESPACE/estimator: ros__parameters: in a file': 'holds for that plant alone',
        },
        (
            'With comments: share/obs_ros/config/fleet.yaml. The parameters of estimator: '
            '`ros2 run obs_ros estimator --help`. How to run fleets: docs/fleets.md.',
        ),
    )
