"""Outliers of successive windows: counted once each, and told in words."""

from collections.abc import Iterable, Sequence

from obs_ros.inference.window_state import Outlier

TOLD = 3  # outliers of an output that a message names: the largest


class OutlierCount:
    """Counts outliers and bursts of each output, each once however many windows hold it."""

    def __init__(self, outputs: Sequence[str]) -> None:
        self._outputs = tuple(outputs)
        kinds = ('outlier', 'burst')
        self._counts = {f'{kind}.{name}': 0 for name in outputs for kind in kinds}
        self._recent: set[tuple[float, int]] = set()

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of single values by `outlier.<output>`, of bursts by `burst.<output>`."""
        return self._counts.copy()

    def note(self, outliers: Sequence[Outlier], start: float) -> None:
        """Count those of a window that starts at `start` (s) and were not counted before."""
        bursts: dict[tuple[float, int], bool] = {}
        found = {(outlier.time, outlier.output) for outlier in outliers}
        for outlier in outliers:
            name, fresh = self._outputs[outlier.output], not self._known(outlier)
            if outlier.burst is None:
                self._counts[f'outlier.{name}'] += fresh
            else:
                place = outlier.burst, outlier.output
                bursts[place] = bursts.get(place, True) and fresh
        for (_, output), fresh in bursts.items():
            self._counts[f'burst.{self._outputs[output]}'] += fresh
        self._recent = {known for known in self._recent | found if known[0] >= start}

    def _known(self, outlier: Outlier) -> bool:
        return (outlier.time, outlier.output) in self._recent


def words(outliers: Iterable[Outlier], outputs: Sequence[str]) -> list[str]:
    """Say for each output which samples were left out, if any were, and which bursts."""
    said, every = [], sorted(outliers, key=lambda o: -o.size)
    for output, name in enumerate(outputs):
        own = [o for o in every if o.output == output and o.burst is None]
        if own:
            largest = ', '.join(_moment(outlier) for outlier in own[:TOLD])
            count = '1 outlier' if len(own) == 1 else f'{len(own)} outliers'
            more = ' and others' if len(own) > TOLD else ''
            said.append(f'{count} of {name} at {largest}{more} left out')
        said += _bursts([o for o in every if o.output == output and o.burst is not None], name)
    return said


def newest(outliers: Iterable[Outlier], outputs: Sequence[str]) -> str:
    """Say of the last one which it is, when and how large; nothing if there is none."""
    last = max(outliers, key=lambda o: o.time, default=None)
    return '' if last is None else f'{outputs[last.output]} at {_moment(last)}'


def _bursts(members: Sequence[Outlier], name: str) -> list[str]:
    """Say of each burst of an output when it was, of its members, largest first."""
    said = []
    for begin in sorted({o.burst for o in members if o.burst is not None}):
        own = [o for o in members if o.burst == begin]
        end = max(o.time for o in own)
        said.append(
            f'look at the sensor of {name}: a burst of {len(own)} values from {begin:.2f} s to '
            f'{end:.2f} s, up to {own[0].size:.3g} sigma, counts as not measured'
        )
    return said


def _moment(outlier: Outlier) -> str:
    return f'{outlier.time:.2f} s ({outlier.size:.3g} sigma)'
