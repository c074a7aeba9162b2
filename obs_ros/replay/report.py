"""The report of a replay: the views of the live page in one file that needs no network."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import Variable, names
from obs_ros.core.record import Sample
from obs_ros.core.texts import LONGEST, one_line
from obs_ros.horizon.prediction import Predicted
from obs_ros.interface.forecast import Forecast
from obs_ros.interface.settings import build_observer
from obs_ros.interface.vectors import Vector, vectors
from obs_ros.pages.information import KINDS, Information, Shown
from obs_ros.pages.observed import Observed
from obs_ros.pages.page import page
from obs_ros.pages.payload import Seen, Told, answer
from obs_ros.pages.thinning import ThinningSettings
from obs_ros.replay.engine import Account
from obs_ros.replay.settings import Setup


@dataclass(frozen=True)
class ReportSettings:
    """Sizes by which a report of any recording opens at once."""

    points: int = 120_000  # of all curves together, some 20 bytes each
    most: int = 2000  # buckets of a curve
    least: int = 50


SETTINGS = ReportSettings()


class Report:
    """Hears a replay as the live page hears the node, predictions and residuals included.

    `heard` goes between the recording and the replay, `take` gets each estimate.
    """

    def __init__(self, setup: Setup) -> None:
        self._model = setup.model
        self._origin: int | None = None
        info = Information.bounded(
            setup.model.name,
            str(setup.values['observer']),
            {kind: _shown(getattr(setup.model, kind)) for kind in KINDS},
        )
        self._observed = Observed(
            one_line(setup.model.name, LONGEST), info, ThinningSettings(rows=SETTINGS.most)
        )
        self._forecast: Forecast | None = None
        if setup.values.get('prediction.enabled'):
            self._forecast = Forecast(setup.model, self._predicted)
            observer = build_observer(setup.model, setup.values)
            self._forecast.follow(setup.values, getattr(observer, 'unknowns', None))
            self._forecast.prepare()

    def heard(self, samples: Iterable[Sample]) -> Iterator[Sample]:
        """Yield the samples, having heard each."""
        outputs, inputs = names(self._model.outputs), names(self._model.inputs)
        for sample in samples:
            self._origin = sample.stamp if self._origin is None else self._origin
            for topic, order, values in (
                ('measured', outputs, sample.y), ('applied', inputs, sample.u),
            ):  # fmt: skip
                if values is not None:
                    row = dict(zip(order, values.tolist(), strict=True))
                    self._observed.hear(Vector(topic, sample.stamp, row))
            if self._forecast is not None:
                self._forecast.absorb(sample, 0.0, silent=lambda: False)
            yield sample

    def take(self, estimate: Estimate, skipped: int) -> None:
        """Hear an estimate, as the node publishes it."""
        figures = {'solve_time_s': estimate.solve_time, 'skipped': float(skipped)}
        self._observed.conclude(estimate.stamp or 0, estimate.outcome.value, estimate.message)
        for vector in vectors(estimate, self._model, figures):
            self._observed.hear(vector)
        if self._forecast is not None:
            self._forecast.start(estimate)

    def text(self, name: str, account: Account, remarks: Sequence[str] = ()) -> str:
        """Return the page; `name` is that of the recording."""
        title = f'Replay of {one_line(name, LONGEST)}'
        return page(title, self._answer(account, remarks))[0]

    def _answer(self, account: Account, remarks: Sequence[str]) -> dict[str, Any]:
        """Return what the page shows, as the live page's server answers."""
        observed, origin = self._observed, self._origin or 0
        newest = observed.newest
        oldest = observed.oldest
        columns = sum(trace.width for trace in observed.traces.values())
        most = max(SETTINGS.least, min(SETTINGS.most, SETTINGS.points // (2 * max(columns, 1))))
        begin = origin if oldest is None else oldest
        seen = Seen(begin, begin if newest is None else newest, origin, most)
        words = (
            f'{account.recorded:.6g} s of recording, {account.samples} samples, '
            f'{len(account.history)} estimates, {account.speed:.3g} times real time'
        )
        notes = [one_line(remark) for remark in remarks]
        if observed.begun_anew:
            notes.append(
                'see the summary for what is before the last time that stamps went far back, which '
                f'is not shown: that was so {observed.begun_anew} time(s)'
            )
        return answer({observed.name: Told(words, well=True)}, [observed], seen, notes)

    def _predicted(self, predicted: Predicted) -> None:
        """Hear a prediction, as the node publishes it."""
        spread = tuple(predicted.residual_stddev.values())
        for vector in (
            Vector('prediction', predicted.stamp, predicted.state),
            Vector('prediction_stddev', predicted.stamp, predicted.stddev),
            Vector('residual', predicted.stamp, predicted.residual, effort=spread),
        ):
            self._observed.hear(vector)


def _shown(variables: Sequence[Variable]) -> tuple[Shown, ...]:
    return tuple(Shown(v.name, '' if v.unit == '1' else v.unit, v.period or 0.0) for v in variables)
