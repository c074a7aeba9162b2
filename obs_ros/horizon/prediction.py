"""The state now: an estimate of some time ago, carried on to the newest output."""

import itertools
import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model, names
from obs_ros.core.periods import periods, within
from obs_ros.core.record import Sample
from obs_ros.core.typing import Array
from obs_ros.horizon.propagation import Interval, Propagation, Start, prepare, propagation
from obs_ros.inference.assessment.identifiability import undetermined_states
from obs_ros.inference.innovation_gate import INNOVATION_GATE, InnovationGateSettings
from obs_ros.inference.parameterisation import Unknowns
from obs_ros.inference.process_noise import estimated_parameters
from obs_ros.integration.backends import Backend
from obs_ros.integration.path import own
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.gate import DEFAULT as GATE
from obs_ros.samples.gate import GateSettings
from obs_ros.samples.stuck_sensor import Repeats
from obs_ros.samples.successive_outputs import SuccessiveOutputs


@dataclass(frozen=True)
class PredictionSettings:
    """The memory of a prediction, in intervals from one output to the next."""

    kept: int = 20000  # that an estimate may be late; 20 s at 1000 Hz
    at_once: int = 1000  # that wait to be integrated where nobody asks; some ms


DEFAULT = PredictionSettings()


class Predicted(NamedTuple):
    """States at the newest output, of `stamp` (ns), by name; NaN = not determined, not measured.

    `residual` is the innovation: that output as measured less as predicted, one step ahead where
    outputs correct the state, else from the estimate. Deviations are standard deviations; of a
    residual that of the noise and of the predicted output together. All in the variables' units.
    """

    stamp: int
    state: Mapping[str, float]
    stddev: Mapping[str, float]
    residual: Mapping[str, float]
    residual_stddev: Mapping[str, float]


class Prediction:
    """Carries the newest estimate on to every output, under the inputs that came since.

    Without process noise the state at the newest output is that of the model alone, x' =
    f(t, x, u, p). Where the estimate tells process noise, the outputs since then, the newest
    included, correct it, but for outliers: see `propagation`. Inputs do as their Variable says, and
    hold their last value. Without a usable estimate there is no prediction; nor does one last
    beyond a value that is not finite.

    Samples enter by the rules of `Gate`; `limit` sets the limits that the observer has, and
    `unknowns` what it estimates (None: all). What a stuck sensor repeats corrects nothing. One
    thread calls everything but `prepare`, which compiles and is for any. Samples that come after an
    estimate are shifted by the delays that it tells.
    """

    def __init__(
        self,
        model: Model,
        backend: Backend | None = None,
        gate: GateSettings = GATE,
        settings: PredictionSettings = DEFAULT,
        unknowns: Unknowns | None = None,
    ) -> None:
        self.model = model
        self.diverged = 0
        self._backend = backend
        self._states, self._outputs = names(model.states), names(model.outputs)
        self._periods = periods(model.states), periods(model.outputs)
        self._take_unknowns(unknowns or Unknowns.of(model))
        self._samples = SuccessiveOutputs(model, gate)
        # Noise is known by the time of a prediction, but not here.
        self._repeats = Repeats([True] * len(model.outputs), outputs=model.outputs)
        self._trail: deque[Interval] = deque(maxlen=settings.kept)  # for estimates to come
        self._rest: list[Interval] = []  # along which the state is to be carried
        self._at_once = settings.at_once
        self._whole = model.period is not None  # steps lead from node to node
        self._carrier: Propagation | None = None
        self._newest: int | None = None
        self.since: int | None = None  # stamp of the estimate
        self._origin = 0.0  # s, where its window began
        self._innovation_gate = INNOVATION_GATE

    def prepare(self, *, correcting: bool = False) -> None:
        """Compile the model's steps, and with `correcting` the filter; may take some seconds."""
        moving = self._moving if correcting else None
        prepare(self.model, self._backend, moving)

    def limit(
        self,
        gate: GateSettings,
        unknowns: Unknowns | None = None,
        innovations: InnovationGateSettings = INNOVATION_GATE,
    ) -> None:
        """Let samples enter by other limits from now on, estimates be about other unknowns.

        Outputs correct the estimates to come by the gate for `innovations`.
        """
        self._innovation_gate = innovations
        self._samples.gate.limit(gate)
        self._take_unknowns(unknowns or Unknowns.of(self.model))

    def forget(self) -> None:
        """Forget all samples and the estimate."""
        self._samples.reset()
        self._forget()

    def end(self) -> None:
        """Forget the estimate: there is no prediction until the next one."""
        self.since = self._carrier = None
        self._rest.clear()

    def absorb(self, sample: Sample) -> int | None:
        """Take a sample; return the stamp (ns) of the output that can be predicted to, if any."""
        if self._samples.push(sample):
            self._forget()
        outputs = self._samples.due
        for stamp, y in outputs:
            stuck = self._repeats.note(y)
            if self._newest is not None:
                path = own(self._samples.inputs.path(self._newest, stamp))
                interval = Interval(self._newest, stamp, path, y, stuck)
                self._trail.append(interval)
                if self.since is not None and stamp > self.since:
                    self._rest.append(interval.cut(self.since, whole=self._whole))
            self._newest = stamp
        if len(self._rest) >= self._at_once:
            self._advance()
        return self._newest if outputs and self.since is not None else None

    def start(self, estimate: Estimate) -> None:
        """Go on from an estimate; from one that is not usable, no more."""
        self.end()
        stamp = estimate.stamp
        if stamp is None or self._newest is None or not estimate.usable:
            return
        stamp = self._known(stamp)
        while self._trail and self._trail[0].end <= stamp:
            self._trail.popleft()
        if stamp < (self._trail[0].begin if self._trail else self._newest):
            return  # the inputs since then are not known any more
        start = Start.of(self.model, estimate, self._moving)
        self._carrier = propagation(self.model, self._backend, start, self._innovation_gate)
        self.since, self._origin = stamp, estimate.t0
        self._samples.gate.shift(Shifts.of(self.model, estimate.parameters))
        self._rest += self._trail
        self._rest[:1] = [interval.cut(stamp, whole=self._whole) for interval in self._rest[:1]]

    def now(self) -> Predicted | None:
        """Return the states at the newest output; None if there is no prediction."""
        if self._carrier is None or self._newest is None:
            return None
        self._advance()
        carried = self._carrier.report()
        x = within(carried.x, self._periods[0]).tolist()
        innovation = within(carried.innovation, self._periods[1]).tolist()
        if not math.isfinite(sum(x)):
            self.diverged += 1
            self.end()
            return None
        stddev = roots(carried.variances, self._undetermined)
        return Predicted(
            # An output that was measured long before its stamp may be older than the estimate.
            self._newest if self.since is None else max(self._newest, self.since),
            dict(zip(self._states, x, strict=True)),
            dict(zip(self._states, stddev, strict=True)),
            dict(zip(self._outputs, innovation, strict=True)),
            dict(zip(self._outputs, roots(carried.S, itertools.repeat(math.inf)), strict=True)),
        )

    def _known(self, stamp: int) -> int:
        """Return the stamp (ns) by which the node of an estimate is known here.

        What has met other samples may have the phase of a discrete model's nodes a little apart.
        """
        if self.model.period is None:
            return stamp
        known = [interval.end for interval in self._trail]
        known += [self._trail[0].begin] if self._trail else [self._newest or stamp]
        nearest = min(known, key=lambda node: abs(node - stamp))
        return nearest if 2e-9 * abs(nearest - stamp) < self.model.period else stamp

    def _take_unknowns(self, unknowns: Unknowns) -> None:
        self._moving = estimated_parameters(unknowns)
        self._undetermined = undetermined_states(unknowns).tolist()

    def _advance(self) -> None:
        if self._rest and self._carrier is not None:
            rest = self._rest
            if self.model.time == 'window':
                rest = [interval.since(self._origin) for interval in rest]
            self._carrier.advance(rest)
            self._rest.clear()

    def _forget(self) -> None:
        self.end()
        self._repeats.clear()
        self._trail.clear()
        self._newest = None


def roots(variances: Array, largest: Iterable[float]) -> list[float]:
    """Return standard deviations; NaN where they are not known, or above the largest."""
    found = [math.sqrt(max(variance, 0.0)) for variance in variances.tolist()]  # a NaN stays one
    return [
        s if s <= most and s < math.inf else math.nan
        for s, most in zip(found, largest, strict=False)
    ]
