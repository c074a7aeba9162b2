"""How many values came from saturated sensors, for the diagnostics."""

from collections.abc import Mapping, Sequence

from obs_ros.core.model import Variable
from obs_ros.core.saturation import ends_of, has_range
from obs_ros.core.typing import Array


class SaturationCount:
    """Counts the values of each output with a range at which its sensor is saturated."""

    def __init__(self, outputs: Sequence[Variable]) -> None:
        self._outputs = tuple(outputs)
        self._ranged = [i for i, v in enumerate(outputs) if v.range is not None]
        self._counts = dict.fromkeys(self._ranged, 0)
        self._needed = has_range(outputs)

    def note(self, y: Array) -> None:
        """Count in measured outputs (r,); NaN = not measured."""
        if not self._needed or (ends := ends_of(self._outputs, y)) is None:
            return
        saturated = ends.saturated.tolist()
        for i in self._ranged:
            self._counts[i] += saturated[i]

    @property
    def counts(self) -> Mapping[str, int]:
        """The numbers so far, by reason: `saturated.<output>`."""
        return {f'saturated.{self._outputs[i].name}': n for i, n in self._counts.items()}
