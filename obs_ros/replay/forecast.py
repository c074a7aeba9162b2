"""Forecasts of the outputs after an estimate, by which no fit can flatter it."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Model
from obs_ros.core.periods import shortest
from obs_ros.core.record import Record, Sample
from obs_ros.core.typing import Array
from obs_ros.horizon.forecasts import FORECASTS
from obs_ros.integration.backends import kernels_for
from obs_ros.integration.grid import Grid
from obs_ros.samples.align import align
from obs_ros.samples.delay_line import Shifts
from obs_ros.samples.gate import Gate, GateSettings
from obs_ros.samples.merge import Role
from obs_ros.samples.stream import InputStream, Stream

NEAR = FORECASTS.horizons[0]  # of the horizon


@dataclass(frozen=True)
class Forecast:
    """The errors of the forecast of one estimate, counted by `index` from 0.

    `rms` (r,) is the root mean square of outputs less those foretold, in their units, and `held`
    (r,) the same of the last output held all the time; `near` and `near_held` (r,) are those of the
    first `NEAR` of the horizon. NaN where there was nothing to compare.
    """

    index: int
    rms: Array
    held: Array
    near: Array
    near_held: Array


class Forecaster:
    """Runs the model on from each estimate through the next `horizon` s, inputs as they came.

    State and parameters are those at the estimate's newest output; the outputs after it, which it
    has not seen, are compared. A forecast is judged when outputs and inputs have passed its end. At
    most `capacity` samples of each stream wait; a forecast whose beginning had to go is given up.
    Samples enter by the rules of `Gate`, as they do to the observer whose `reach` (s) is given.
    """

    passed = None  # see `Store`

    def __init__(self, model: Model, horizon: float, reach: float, capacity: int) -> None:
        self._model = model
        self._horizon = round(horizon * 1e9)
        self._capacity = capacity
        self._outputs = Stream(len(model.outputs), capacity)
        self._inputs = InputStream(len(model.inputs), capacity)
        self._gate = Gate.of(model, self, GateSettings(reach=reach))
        shifts = Shifts.of(model)
        self._past = 0 if shifts is None else shifts.past
        self._kinds = [variable.interpolation for variable in model.inputs]
        self._open: deque[tuple[int, int, float, Array, Array]] = (
            deque()
        )  # index, stamp, start of the window in s, state, parameters

    def push(self, sample: Sample) -> None:
        """Take a sample that the observer gets too; a new timeline ends all open forecasts."""
        self._gate.push(sample)

    def keep(self, role: Role, stamp: int, values: Array) -> bool:
        """See `Store`."""
        stream = self._inputs if role == 'input' else self._outputs
        kept = stream.add(stamp, values)
        if len(stream) > self._capacity:
            stream.drop(1)
        return kept

    def forget(self) -> None:
        """See `Store`."""
        self._outputs.clear()
        self._inputs.clear()
        self._open.clear()

    def add(self, index: int, estimate: Estimate) -> None:
        """Let an estimate foretell, unless it is not usable."""
        if estimate.usable and estimate.stamp is not None:
            x, p = (
                np.array(list(values.values()), dtype=np.float64)
                for values in (estimate.state, estimate.parameters)
            )
            self._open.append((index, estimate.stamp, estimate.t0, x, p))

    def judge(self) -> list[Forecast]:
        """Return the forecasts that can be judged since the last call."""
        found = []
        while self._open and self._passed(self._open[0][1] + self._horizon):
            index, stamp, start, x, p = self._open.popleft()
            self._outputs.drop_until(stamp - 1)
            self._inputs.drop_until(stamp - self._past - 1)
            if not len(self._outputs) or self._outputs.stamps[0] != stamp:
                continue
            end = stamp + self._horizon
            streams, nodes = (self._outputs, self._inputs), self._model.period
            record = align(*streams, end, self._kinds, self._past, nodes)
            if record is not None and not np.isnan(record.u[0]).any():
                found.append(self._compare(index, record, start, x, p))
        return found

    def _passed(self, end: int) -> bool:
        reached = self._gate.reached()
        return reached is not None and reached >= end

    def _compare(self, index: int, record: Record, start: float, x: Array, p: Array) -> Forecast:
        grid = Grid.of(self._model, record, np.ones(len(self._model.outputs)), start)
        with np.errstate(all='ignore'):
            outputs = kernels_for(self._model).trajectories(grid, x[:, None], p[:, None])[1]
            foretold = grid.shown(outputs)[:, :, 0]
            error = shortest(record.y - foretold, grid.period)
            error = np.where(np.isfinite(foretold), error, math.inf)
            error[np.isnan(record.y)] = math.nan
            change = shortest(record.y - record.y[0], grid.period)
        near = record.t <= record.t[0] + NEAR * self._horizon / 1e9
        errors = [e[part][1:] for part in (slice(None), near) for e in (error, change)]
        return Forecast(index, *map(_rms, errors))


def _rms(errors: Array) -> Array:
    """Return the root mean square (r,) of errors (K, r); NaN = nothing measured."""
    columns = [column[~np.isnan(column)] for column in errors.T]
    with np.errstate(over='ignore'):
        return np.array([math.sqrt(np.mean(c**2)) if c.size else math.nan for c in columns])
