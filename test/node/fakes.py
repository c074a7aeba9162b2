"""Observers that do as a test tells them, named `node.fakes:...` wherever a name goes."""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from patience import patience

from obs_ros.core.estimate import Estimate, Outcome
from obs_ros.core.model import Model, Variable, names
from obs_ros.core.plain_data import Shapes, from_plain
from obs_ros.core.record import Sample
from obs_ros.models import load_model
from obs_ros.observers.output_intake import Instant
from obs_ros.observers.recursive import RecursiveObserver
from obs_ros.observers.settings import Settings, setting


def swing(t, x, u, p):
    return x[1], u[0] - p[0] * x[0]


# Bounds, nominal value and walk are integers, as users write them.
SWING = Model(
    'swing',
    states=(Variable('angle', 'rad', lower=-3, upper=3), Variable('rate', lower=-9, upper=9)),
    inputs=(Variable('torque', nominal=1),),
    outputs=(Variable('angle', 'rad'),),
    parameters=(Variable('stiffness', lower=1, upper=30, nominal=8, walk=1),),
    dynamics=swing,
    output=lambda t, x, u, p: (x[0],),
    max_step=1,
)


class FakeObserver:
    """Is due at every `duration`-th output; estimates that output, and how many there were."""

    immediate = False
    made: list['FakeObserver'] = []  # noqa: RUF012 - tests look the last one up here

    def __init__(self, model: Any, *, duration: float, **settings: Any) -> None:
        if settings['seed'] == 13:
            raise ValueError('seed 13 brings bad luck')
        self.model = load_model(model)
        self.duration, self.settings = duration, settings
        self.outputs: list[Sample] = []
        self.inputs: list[Sample] = []
        self.resets = 0
        self.skipped = 0
        self.last_break: str | None = None
        self.go = threading.Event()
        self.go.set()
        self.value: float | Exception | None = None
        self.says: dict[str, Any] = {}  # further fields of its estimates
        FakeObserver.made.append(self)

    def prepare(self) -> float:
        return 0.5

    def prepare_more(self) -> bool:
        return False

    def absorb(self, sample: Sample) -> bool:
        if sample.y is None:
            self.inputs.append(sample)
            return False
        if self.outputs and sample.stamp < self.outputs[-1].stamp:
            self.last_break = f'stamps jumped back to {sample.stamp}'
            self.outputs.clear()
        self.outputs.append(sample)
        return len(self.outputs) % round(self.duration) == 0

    def estimate(self, deadline: float | None = None) -> Estimate | None:
        count, newest = len(self.outputs), self.outputs[-1].stamp
        assert self.go.wait(patience(10.0))
        if isinstance(self.value, Exception):
            raise self.value
        value = float(count) if self.value is None else self.value
        vector = dict.fromkeys(names(self.model.states), value)
        finite = math.isfinite(value)
        return Estimate(
            parameters=dict.fromkeys(names(self.model.parameters), value),
            initial_state=vector,
            state=vector,
            stddev={'h1': 0.25},
            outcome=Outcome.CONVERGED if finite else Outcome.DIVERGED,
            message='as told',
            t0=0.0,
            t1=newest * 1e-9,
            cost=2.0,
            residual_rms=0.1,
            evaluations=7,
            solve_time=0.01,
            stamp=newest,
            **self.says,
        )

    def inherit(self, other: 'FakeObserver') -> bool:
        return False

    def reset(self) -> None:
        self.resets += 1
        self.outputs.clear()

    @property
    def collected(self) -> float | None:
        return None

    @property
    def counts(self) -> Mapping[str, int]:
        return {'late': 3, 'skipped': self.skipped}


@dataclass(frozen=True)
class Seen:
    """How many outputs a fake had seen."""

    outputs: int


class RememberingFake(FakeObserver):
    """Remembers how many outputs it and those before it have seen."""

    remembers = True
    identity: Mapping[str, str] = {}
    before = 0

    @property
    def memory(self) -> Seen | None:
        seen = self.before + len(self.outputs)
        return Seen(seen) if seen else None

    def recall(self, plain: Any) -> None:
        found: Seen = from_plain(Seen, plain, Shapes())
        self.before = found.outputs

    def reset(self) -> None:
        super().reset()
        self.before = 0


@dataclass(frozen=True)
class FakeSettings(Settings):
    gain: float = setting(0.5, 'share of an error that is corrected', lower=0.0, upper=1.0)
    mode: str = setting('plain', 'how', choices=('plain', 'fancy'))
    table: tuple[float, ...] = setting((1.0, 2.0), 'two numbers', length=2)


class FakeImmediate(RecursiveObserver):
    """Takes the first output for every state; tells its gain. An output of 666 is too much."""

    Settings = FakeSettings
    made: list['FakeImmediate'] = []  # noqa: RUF012
    go = threading.Event()

    def __init__(self, model: Any, **arguments: Any) -> None:
        super().__init__(model, **arguments)
        FakeImmediate.made.append(self)

    def prepare(self) -> float:
        assert FakeImmediate.go.wait(patience(10.0))
        return 0.5

    def _start(self, now: Instant) -> None:
        self._step(now, now, None)

    def _step(self, before: Instant, now: Instant, path: Any) -> None:
        if now.y[0] == 666.0:
            raise RuntimeError('the number of the beast')
        self.x[:] = now.y[0]
        self.stddev[0] = 0.25
        self.figures['gain'] = self.settings.gain
