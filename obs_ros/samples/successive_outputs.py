"""Outputs one after the other, and the inputs between them, for whoever steps along them."""

from collections.abc import Mapping

import numpy as np

from obs_ros.core.model import Model
from obs_ros.core.record import Sample
from obs_ros.core.typing import Array
from obs_ros.integration.input_history import InputHistory
from obs_ros.samples.gate import COUNTS as ENTERING
from obs_ros.samples.gate import Gate, GateSettings
from obs_ros.samples.merge import Role
from obs_ros.samples.saturation_count import SaturationCount
from obs_ros.samples.stuck_sensor import Repeats

COUNTS = {
    **ENTERING,
    'stuck': 'outputs with entries that a stuck sensor repeats, which count as not measured',
    'early': 'outputs dropped: not every input had a value yet',
    'overflow': 'inputs dropped, oldest first: too many came without an output',
}


class SuccessiveOutputs:
    """Hands the outputs out, each newer than the last, and keeps the inputs from the last one on.

    Samples enter by the rules of `Gate`. An output is handed out when it comes, and has then been
    passed: an input that comes late is in force from there on. With `repeats`, entries that a stuck
    sensor repeats count as not measured. At most `capacity` inputs wait for an output.
    """

    def __init__(
        self,
        model: Model,
        settings: GateSettings,
        repeats: Repeats | None = None,
        capacity: int = 4096,
    ) -> None:
        self.inputs = InputHistory(model)
        self.due: list[tuple[int, Array]] = []  # stamps (ns) and values (r,) out of the last `push`
        self.gate = Gate.of(model, self, settings)
        self._repeats = repeats
        self._saturation = SaturationCount(model.outputs)
        self._capacity = capacity
        self._counts = dict.fromkeys(COUNTS.keys() - ENTERING.keys(), 0)
        self._last: int | None = None  # stamp of the output handed out last

    @property
    def counts(self) -> Mapping[str, int]:
        """Numbers of samples dropped, mended or saturated since construction, by reason."""
        return {**self.gate.counts, **self._counts, **self._saturation.counts}

    @property
    def passed(self) -> int | None:
        """See `Store`; an input with the very stamp of the last output is in time."""
        return None if self._last is None else self._last - 1

    def push(self, sample: Sample) -> bool:
        """Take a sample; return whether it began a new timeline, to which `due` then belongs.

        Raises ValueError if the number of outputs or inputs is wrong.
        """
        self.due = []
        return self.gate.push(sample)

    def reset(self) -> None:
        """Forget all samples, but not the counts."""
        self.gate.reset()
        self.forget()

    def forget(self) -> None:
        """See `Store`."""
        self.inputs.clear()
        self.due.clear()
        self._last = None
        if self._repeats is not None:
            self._repeats.clear()

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """See `Store`."""
        if role == 'output':
            return self._hand_out(stamp, values)
        kept = self.inputs.add(stamp, values)
        if len(self.inputs) > self._capacity:
            self.inputs.drop(1)
            self._counts['overflow'] += 1
        return kept

    def _hand_out(self, stamp: int, values: Array) -> bool:
        """Let an output be due, unless there is nothing to it; False if its stamp was before."""
        if stamp == self._last:
            return False
        self._saturation.note(values)
        if self._repeats is not None and (stuck := self._repeats.note(values)):
            self._counts['stuck'] += 1
            values[list(stuck)] = np.nan
            if np.isnan(values).all():
                return True
        if self.inputs.known_at(stamp):
            self._last = stamp
            self.due.append((stamp, values))
        else:
            self._counts['early'] += 1
            self.inputs.drop_before(stamp)
        return True
