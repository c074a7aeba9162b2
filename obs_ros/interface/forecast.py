"""~/prediction: the state propagated from the last estimate on, sample by sample."""

import time
from collections.abc import Callable, Mapping
from typing import Any

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.core.record import Sample
from obs_ros.horizon.prediction import Predicted, Prediction
from obs_ros.inference.innovation_gate import INNOVATION_GATE, InnovationGateSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.samples.gate import GateSettings


class Forecast:
    """Hands predictions to `publish`, `rate` per s of sample time at most.

    A rate of 0 means one for every output. `latency` (s) is from the arrival of the newest output
    to its prediction.
    """

    def __init__(self, model: Model, publish: Callable[[Predicted], None]) -> None:
        self.rate = 0.0
        self.published = 0
        self.latency = 0.0
        self._prediction = Prediction(model)
        self._publish = publish
        self._correcting = False
        self._last: int | None = None

    @property
    def diverged(self) -> int:
        """Number of predictions that were not finite, and withheld."""
        return self._prediction.diverged

    @property
    def horizon(self) -> float | None:
        """Sample time (s) from the estimate to the last prediction; None without any."""
        since = self._prediction.since
        return None if since is None or self._last is None else (self._last - since) / 1e9

    def prepare(self) -> float:
        """Compile everything that is not compiled yet; return the seconds that it took."""
        begin = time.perf_counter()
        self._prediction.prepare(correcting=self._correcting)
        return time.perf_counter() - begin

    def start(self, estimate: Estimate) -> None:
        """Go on from an estimate."""
        self._prediction.start(estimate)

    def follow(self, values: Mapping[str, Any], unknowns: Unknowns | None = None) -> None:
        """Do as the node's parameters say, for an observer of these unknowns; None = all."""
        self.rate = values['prediction.rate']
        gate = INNOVATION_GATE if values['loss'] == 'robust' else InnovationGateSettings(limit=0.0)
        self._prediction.limit(GateSettings(reach=window_reach(values)), unknowns, gate)
        self._correcting = values['process_noise'] != 'off'

    def end(self) -> None:
        """Forget the estimate: the observer has begun a new timeline."""
        self._prediction.end()
        self._last = None

    def forget(self) -> None:
        """Forget samples and estimate."""
        self._prediction.forget()
        self._last = None

    def absorb(self, sample: Sample, arrival: float, *, silent: Callable[[], bool]) -> None:
        """Take a sample that came at `arrival` (steady clock, s); predict unless `silent()`."""
        stamp = self._prediction.absorb(sample)
        if stamp is None or not self._is_time(stamp) or silent():
            return
        predicted = self._prediction.now()
        if predicted is not None:
            self._last = stamp
            self._publish(predicted)
            self.published += 1
            self.latency = time.monotonic() - arrival

    def _is_time(self, stamp: int) -> bool:
        if not self.rate or self._last is None:
            return True
        since = stamp - self._last
        return since < 0 or since * self.rate >= 1e9  # the former: of a new timeline


def window_reach(values: Mapping[str, Any]) -> float:
    """Return the reach (s) of the windows that the parameters ask for; see `SlidingWindow`."""
    duration: float = values['window.duration']
    return duration + (values['window.period'] or duration)
