"""The estimates of a replay as numbers, small enough to be kept whatever was replayed."""

import math
from array import array
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from obs_ros.core.estimate import UNKNOWN, Estimate, Jump
from obs_ros.core.model import Model, names
from obs_ros.core.periods import periods, within
from obs_ros.core.record import Sample
from obs_ros.core.typing import Array, IntArray
from obs_ros.replay.forecast import Forecast
from obs_ros.replay.trace import Trace

FORECASTS = ('forecasts', 'held', 'near', 'near_held')


class History:
    """Numbers of the estimates, in their order; NaN where there is none.

    Of the arrays, `values`, `deviations`, `lower` and `upper` (K, n + q) are those of states, then
    parameters: estimates, standard deviations, and the ends of 95 % intervals. `residuals`,
    `forecasts`, `held`, `near` and `near_held` (K, r) are root mean squares by output (see
    `Forecast`), `rms` (K, 1) over all outputs. `walks` (K, n + q) are the process noise that
    explains a window, `skill` (K, 1) is the skill of its forecasts, `scatter` (K, q) that of
    disjoint windows over their standard deviations, as far as an estimate's figures tell. Of the
    traces, `measured` (K, r) and `applied` (K, m) are as recorded; `path` (K, n + q) are the states
    that the windows found for their samples, each sample by the first window that holds it, and the
    parameters at that time. The first `most_jumps` jumps and retractions are kept, in little memory
    whatever is announced; all are counted, and so are the estimates in which a parameter drifts.
    """

    def __init__(self, model: Model, most_jumps: int = 1000) -> None:
        self.model = model
        self._most_jumps = most_jumps
        self.outcomes: Counter[str] = Counter()
        self.messages: dict[str, str] = {}  # the last of each outcome
        self.weak: Counter[str] = Counter()
        self.jumps: list[Jump] = []  # when they were announced or taken back
        self.jump_count = self.retraction_count = 0
        self.drifting: Counter[str] = Counter()
        self.solve_time = 0.0  # s, all together
        self._unknowns, self._outputs = names(model.variables), names(model.outputs)
        self._stamps = array('q')
        self._outcomes: list[str] = []
        width, r = len(self._unknowns), len(self._outputs)
        self._widths = {
            'values': width, 'deviations': width, 'lower': width, 'upper': width,
            'residuals': r, 'rms': 1, **dict.fromkeys(FORECASTS, r),
            'walks': width, 'skill': 1, 'scatter': len(model.parameters),
        }  # fmt: skip
        self._numbers = {kind: array('d') for kind in self._widths}
        self.path, self._followed = Trace(width), -(2**62)  # ns, where it ends
        self.measured, self.applied = Trace(r), Trace(len(model.inputs))

    def __len__(self) -> int:
        return len(self._stamps)

    def record(self, sample: Sample) -> None:
        """Note the measured outputs, or the applied inputs."""
        for trace, values in ((self.measured, sample.y), (self.applied, sample.u)):
            if values is not None and trace.width:
                trace.add(sample.stamp, values)

    def add(self, estimate: Estimate) -> int:
        """Note an estimate; return its index."""
        values = {**estimate.state, **estimate.parameters}
        outcome = estimate.outcome.value
        self.outcomes[outcome] += 1
        self.messages[outcome] = estimate.message
        self.weak.update(estimate.weak)
        new = [jump for jump in estimate.jumps if jump.new]
        back = sum(jump.retracted for jump in new)
        self.jump_count += len(new) - back
        self.retraction_count += back
        self.drifting.update(estimate.drifting)
        self.jumps += new[: self._most_jumps - len(self.jumps)]
        self.solve_time += estimate.solve_time
        self._stamps.append(estimate.stamp or 0)
        self._outcomes.append(outcome)
        ends = [estimate.interval.get(name, UNKNOWN) for name in self._unknowns]
        blank = [math.nan] * len(self._outputs)
        figures = estimate.figures
        rows: dict[str, Iterable[float]] = {
            'values': (values[name] for name in self._unknowns),
            'deviations': (estimate.stddev.get(name, math.nan) for name in self._unknowns),
            'lower': (lower for lower, _ in ends),
            'upper': (upper for _, upper in ends),
            'residuals': (estimate.output_rms.get(name, math.nan) for name in self._outputs),
            'rms': (estimate.residual_rms,),
            **dict.fromkeys(FORECASTS, blank),
            'walks': (estimate.walks.get(name, math.nan) for name in self._unknowns),
            'skill': (figures.get('forecast_skill', math.nan),),
            'scatter': (
                figures.get(f'scatter_over_sd.{name}', math.nan)
                for name in names(self.model.parameters)
            ),
        }
        for kind, row in rows.items():
            self._numbers[kind].extend(row)
        self._follow(estimate)
        return len(self) - 1

    def _follow(self, estimate: Estimate) -> None:
        """Let the path go on through the samples that no earlier window held."""
        if not estimate.usable or estimate.stamp is None:
            return
        parameters = np.array(list(estimate.parameters.values()), dtype=np.float64)
        if not estimate.times.size:  # an observer that goes sample by sample
            self.path.add(estimate.stamp, (*estimate.state.values(), *parameters))
            return
        states = within(estimate.states, periods(self.model.states))
        stamps = estimate.stamp + np.round((estimate.times - estimate.t1) * 1e9).astype(np.int64)
        fresh = slice(np.searchsorted(stamps, self._followed, side='right'), None)
        rows = np.hstack([states, np.tile(parameters, (stamps.size, 1))])
        n = states.shape[1]
        for jump in estimate.jumps:
            for place, name in enumerate(estimate.parameters, n):
                rows[estimate.times < jump.time, place] -= jump.sizes.get(name, 0.0)
        for stamp, row in zip(stamps[fresh], rows[fresh], strict=True):
            self.path.add(int(stamp), row)
        self._followed = int(stamps[-1])

    def judged(self, forecasts: Sequence[Forecast]) -> None:
        """Note the errors of forecasts."""
        width = len(self._outputs)
        for forecast in forecasts:
            place = slice(width * forecast.index, width * (forecast.index + 1))
            errors = (forecast.rms, forecast.held, forecast.near, forecast.near_held)
            for kind, row in zip(FORECASTS, errors, strict=True):
                self._numbers[kind][place] = array('d', row)

    @property
    def standing(self) -> Sequence[Jump]:
        """The jumps kept that were announced, and not taken back since."""
        standing: list[Jump] = []
        for jump in self.jumps:
            if jump.retracted:
                standing = [other for other in standing if not jump.takes_back(other)]
            else:
                standing.append(jump)
        return standing

    @property
    def stamps(self) -> IntArray:
        """Stamps (K,) in ns."""
        return np.array(self._stamps, dtype=np.int64)

    @property
    def outcome_of(self) -> Sequence[str]:
        """The outcome of each estimate."""
        return self._outcomes

    def rows(self, kind: str) -> Array:
        """Return the numbers of one kind, a row for each estimate."""
        numbers = np.array(self._numbers[kind], dtype=np.float64)
        return numbers.reshape(-1, self._widths[kind])
