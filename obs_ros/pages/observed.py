"""One estimator as heard on its topics, kept in bounded memory. Knows no ROS."""

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from obs_ros.core.estimate import SAME_TIME
from obs_ros.core.texts import LONGEST_LINE, LONGEST_NAME, one_line
from obs_ros.interface.vectors import Vector
from obs_ros.pages.information import Information, Shown
from obs_ros.pages.thinning import SETTINGS, Thinned, ThinningSettings

FIGURES = ('solve_time_s', 'latency_s', 'forecast_skill', 'residual_rms')
MOST_JUMPS = 200
MOST_SPELLS = 500  # runs of estimates with the same outcome
WAITING = 2000  # values that wait for their standard deviations, which come on another topic
# Of vectors with standard deviations each variable has a value and the ends of value +- 2 sd.
BANDS = {'state': 'states', 'parameters': 'parameters', 'prediction': 'states'}
PLAIN = {
    'measured': 'outputs', 'applied': 'inputs', 'true_state': 'states',
    'true_parameters': 'parameters',
}  # fmt: skip


@dataclass(frozen=True)
class HeardJump:
    """A jump as published: stamp (ns), sizes and their standard deviations by name."""

    stamp: int
    sizes: Mapping[str, float]
    stddev: Mapping[str, float]
    probability: float
    retracted: bool = False


@dataclass(frozen=True)
class Spell:
    """So many estimates in a row with one outcome, from stamp `begin` to `end` (ns)."""

    begin: int
    end: int
    outcome: str
    message: str
    count: int = 1


@dataclass
class _Pairing:
    """Values of one topic and their standard deviations, from another, by the stamp of both.

    Each topic brings its messages in order. So what came before a pair has lost its other half on
    the way: values go without a band then.
    """

    values: dict[int, Sequence[float]] = field(default_factory=dict)
    deviations: dict[int, Sequence[float]] = field(default_factory=dict)

    def rows(self, stamp: int) -> list[tuple[int, list[float]]]:
        """Take out what is complete, or waits in vain, now that something came with a stamp."""
        spread: dict[int, Sequence[float]] = {}
        found: list[tuple[int, Sequence[float]]] = []
        if stamp in self.values and stamp in self.deviations:
            spread = dict(_taken_through(self.deviations, stamp))
            found = _taken_through(self.values, stamp)
        for waiting, given_up in ((self.values, found), (self.deviations, [])):
            if len(waiting) > WAITING:
                given_up += _taken_through(waiting, next(iter(waiting)))
        return [
            (at, _with_band(values, spread.get(at, [math.nan] * len(values))))
            for at, values in found
        ]


class Observed:
    """What was heard of the estimator `name`, whose ~/info says `info`.

    A stamp that goes far back begins anew: the plant was started again.
    """

    def __init__(self, name: str, info: Information, settings: ThinningSettings = SETTINGS) -> None:
        self.name, self.info = name, info
        self.begun_anew = 0  # how often
        self._variables: dict[str, tuple[Shown, ...]] = {
            **{topic: getattr(info, kind) for topic, kind in (*BANDS.items(), *PLAIN.items())},
            'residual': info.outputs,
            'solver': tuple(Shown(figure) for figure in FIGURES),
        }
        width = {**dict.fromkeys(BANDS, 3), 'residual': 2}
        self.traces = {
            topic: Thinned(width.get(topic, 1) * len(each), settings)
            for topic, each in self._variables.items()
        }
        self.clear()

    def clear(self) -> None:
        """Forget all that was heard."""
        for trace in self.traces.values():
            trace.clear()
        self.jumps: deque[HeardJump] = deque(maxlen=MOST_JUMPS)
        self.spells: deque[Spell] = deque(maxlen=MOST_SPELLS)
        self._pairings = {topic: _Pairing() for topic in BANDS}

    @property
    def newest(self) -> int | None:
        """The newest stamp (ns) of all; None before anything was heard."""
        return max((t.newest for t in self.traces.values() if t.newest is not None), default=None)

    @property
    def oldest(self) -> int | None:
        """The oldest stamp (ns) that is kept; None before anything was heard."""
        kept = [trace.oldest for trace in self.traces.values()]
        return min((stamp for stamp in kept if stamp is not None), default=None)

    def variables(self, topic: str) -> tuple[Shown, ...]:
        """Return the variables of a trace, in the order of its columns."""
        return self._variables[topic]

    def hear(self, vector: Vector) -> None:
        """Take a vector from one of the estimator's topics, or its plant's (see `PLAIN`).

        Names that the info lacks are left alone, those that are missing are NaN; topics that are
        not shown are ignored.
        """
        topic = vector.topic
        if topic == 'jump':
            self._jump(vector)
        elif topic in BANDS:
            self._pairings[topic].values[vector.stamp] = self._ordered(topic, vector.values)
            self._add_paired(topic, vector.stamp)
        elif topic.removesuffix('_stddev') in BANDS:
            topic = topic.removesuffix('_stddev')
            self._pairings[topic].deviations[vector.stamp] = self._ordered(topic, vector.values)
            self._add_paired(topic, vector.stamp)
        elif topic == 'residual':
            spread = dict(zip(vector.values, vector.effort, strict=False))
            pairs = zip(
                self._ordered(topic, vector.values), self._ordered(topic, spread), strict=True
            )
            self._add(topic, vector.stamp, [value for pair in pairs for value in pair])
        elif topic in self.traces:
            self._add(topic, vector.stamp, self._ordered(topic, vector.values))

    def conclude(self, stamp: int, outcome: str, message: str) -> None:
        """Take the outcome of an estimate, whose stamp is in ns."""
        outcome, message = one_line(outcome, LONGEST_NAME), one_line(message, LONGEST_LINE)
        last = self.spells[-1] if self.spells else None
        if last is not None and last.outcome == outcome and stamp >= last.begin:
            if stamp > last.end:
                self.spells[-1] = replace(last, end=stamp, message=message, count=last.count + 1)
        elif last is None or stamp != last.end:
            self.spells.append(Spell(stamp, stamp, outcome, message))

    def _ordered(self, topic: str, values: Mapping[str, float]) -> list[float]:
        return [values.get(each.name, math.nan) for each in self._variables[topic]]

    def _add_paired(self, topic: str, stamp: int) -> None:
        for at, row in self._pairings[topic].rows(stamp):
            self._add(topic, at, row)

    def _add(self, topic: str, stamp: int, row: Iterable[float]) -> None:
        trace = self.traces[topic]
        if not trace.width:
            return
        if trace.goes_back(stamp):
            self.clear()
            self.begun_anew += 1
        trace.add(stamp, row)

    def _jump(self, vector: Vector) -> None:
        names = [each.name for each in self.info.parameters]
        sizes = {name: size for name, size in vector.values.items() if name in names}
        if not sizes:
            return
        if all(size == 0.0 for size in sizes.values()):
            for place, jump in enumerate(self.jumps):
                same = abs(jump.stamp - vector.stamp) <= SAME_TIME * 1e9
                if same and set(jump.sizes) <= set(sizes):
                    self.jumps[place] = replace(jump, retracted=True)
            return
        stddev = dict(zip(vector.values, vector.effort, strict=False))
        probability = vector.velocity[0] if len(vector.velocity) else math.nan
        self.jumps.append(HeardJump(vector.stamp, sizes, stddev, probability))


def _taken_through(
    waiting: dict[int, Sequence[float]], stamp: int
) -> list[tuple[int, Sequence[float]]]:
    """Take out what came before a stamp, and with it; in that order."""
    taken: list[tuple[int, Sequence[float]]] = []
    while waiting and (not taken or taken[-1][0] != stamp):
        first = next(iter(waiting))
        taken.append((first, waiting.pop(first)))
    return taken


def _with_band(values: Sequence[float], deviations: Sequence[float]) -> list[float]:
    """Return each value with the ends of value +- 2 sd."""
    return [
        number
        for value, sd in zip(values, deviations, strict=True)
        for number in (value, value - 2.0 * sd, value + 2.0 * sd)
    ]
