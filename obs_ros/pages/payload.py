"""What a page draws of an estimator, as plain numbers and texts that JSON takes."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from obs_ros.core.estimate import Outcome, probability_words
from obs_ros.core.typing import Array, IntArray
from obs_ros.pages.information import Shown
from obs_ros.pages.observed import FIGURES, HeardJump, Observed
from obs_ros.pages.thinning import Extremes
from obs_ros.pages.whiteness import autocorrelation

DIGITS = 7  # of a number: a screen shows four
MICROSECONDS = 6  # decimals of a time in s
BAND = 3  # columns of a value with its band
FIGURE_WORDS = {
    'forecast_skill': ('forecast skill', '1: perfect, 0: as holding the last value'),
    'solve_time_s': ('solve time', 's'),
    'latency_s': ('lag', 's'),
    'residual_rms': ('residual rms', ''),
}


@dataclass(frozen=True)
class Seen:
    """The part that is looked at: stamps `begin` to `end` (ns), times counted from `origin` (ns).

    Of each curve `most` buckets are given, each of which has two points at most.
    """

    begin: int
    end: int
    origin: int
    most: int = 500

    def seconds(self, stamps: IntArray) -> list[float]:
        """Return times (K,) in s."""
        found: list[float] = np.round((stamps - self.origin) / 1e9, MICROSECONDS).tolist()
        return found


class Told(NamedTuple):
    """An estimator in a sentence, and whether that is well.

    Besides, how many of its messages were `lost`, and its `plant`: estimators that hear the same
    topics share one.
    """

    words: str
    well: bool
    lost: int = 0
    plant: str = ''


def answer(
    told: Mapping[str, Told], shown: Sequence[Observed], seen: Seen, notes: Sequence[str]
) -> dict[str, Any]:
    """Return all that a page shows: the estimators by name, and those that are drawn."""
    return {
        'origin': str(seen.origin),
        'from': (seen.begin - seen.origin) / 1e9,
        'to': (seen.end - seen.origin) / 1e9,
        'notes': list(notes),
        'estimators': [
            {'name': name, 'words': each.words, 'well': each.well} for name, each in told.items()
        ],
        'shown': [payload(each, seen) | told[each.name]._asdict() for each in shown],
    }


def payload(observed: Observed, seen: Seen) -> dict[str, Any]:
    """Return panels, jumps and outcomes of an estimator, as far as they are seen."""
    info = observed.info
    last = observed.spells[-1] if observed.spells else None
    return {
        'name': observed.name,
        'model': info.model,
        'observer': info.observer,
        'left_out': info.left_out,
        'outcome': None if last is None else {
            'outcome': last.outcome, 'message': last.message, 'good': good(last.outcome),
        },
        'panels': [*_panels(observed, seen)],
        'jumps': [
            _jump(jump, seen) for jump in observed.jumps if seen.begin <= jump.stamp <= seen.end
        ],
        'spells': [
            {
                'from': (spell.begin - seen.origin) / 1e9, 'to': (spell.end - seen.origin) / 1e9,
                'outcome': spell.outcome, 'message': spell.message, 'count': spell.count,
                'good': good(spell.outcome),
            }
            for spell in observed.spells
            if spell.end >= seen.begin and spell.begin <= seen.end
        ],
    }  # fmt: skip


def good(outcome: str) -> str:
    """Return how far an outcome lets estimates be used: 'yes', 'roughly' or 'no'."""
    if outcome in (Outcome.CONVERGED, Outcome.AT_BOUND):
        return 'yes'
    return 'roughly' if outcome in (Outcome.APPROXIMATE, Outcome.NOT_IDENTIFIABLE) else 'no'


def numbers(values: Array) -> list[float | None]:
    """Return values (K,) to seven digits, None for those that are not finite."""
    finite = np.isfinite(values)
    with np.errstate(all='ignore'):
        tens = np.floor(np.log10(np.abs(values)))
        scale = 10.0 ** (DIGITS - 1 - np.where(np.isfinite(tens), tens, 0.0))
        rounded = np.round(values * scale) / scale
    plain = np.where(np.isfinite(rounded), rounded, values).tolist()
    return [value if known else None for value, known in zip(plain, finite.tolist(), strict=True)]


def number(value: float) -> float | None:
    """Return a value to seven digits, None if it is not finite."""
    return numbers(np.array([value]))[0]


def _panels(observed: Observed, seen: Seen) -> Iterator[dict[str, Any]]:
    cut = {
        topic: trace.between(seen.begin, seen.end, seen.most)
        for topic, trace in observed.traces.items()
    }
    outputs = [each.name for each in observed.info.outputs]
    states = [each.name for each in observed.info.states]
    for place, variable in enumerate(observed.info.parameters):
        yield _panel('parameter', variable, [
            *_curve('truth', cut['true_parameters'], place, seen),
            *_band('estimate', cut['parameters'], place, seen),
        ])  # fmt: skip
    for place, variable in enumerate(observed.info.states):
        measured = [] if variable.name not in outputs else _curve(
            'measured', cut['measured'], outputs.index(variable.name), seen
        )  # fmt: skip
        yield _panel('state', variable, [
            *measured,
            *_curve('truth', cut['true_state'], place, seen),
            *_band('prediction', cut['prediction'], place, seen),
            *_band('estimate', cut['state'], place, seen),
        ])  # fmt: skip
    for place, variable in enumerate(observed.info.outputs):
        if variable.name not in states:
            yield _panel('output', variable, _curve('measured', cut['measured'], place, seen))
    for place, variable in enumerate(observed.info.inputs):
        yield _panel('input', variable, _curve('applied', cut['applied'], place, seen))
    for place, variable in enumerate(observed.info.outputs):
        yield _residual(observed, cut['residual'], place, variable, seen)
    for place, name in enumerate(FIGURES):
        title, unit = FIGURE_WORDS[name]
        curve = _curve('figure', cut['solver'], place, seen)
        if curve:
            yield _panel('figure', Shown(title, unit), curve)


def _panel(kind: str, variable: Shown, curves: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {
        'kind': kind, 'name': variable.name, 'unit': variable.unit, 'period': variable.period,
        'curves': list(curves),
    }  # fmt: skip


def _residual(
    observed: Observed, cut: Extremes, place: int, variable: Shown, seen: Seen
) -> dict[str, Any]:
    """Return the panel of one output's residual, with +-2 sd and its autocorrelation."""
    curves = _curve('residual', cut, 2 * place, seen)
    for curve in curves:
        reach = 2.0 * cut.high[:, 2 * place + 1]
        curve['band'] = _edges(cut.high_at[:, 2 * place], -reach, reach, seen)
    _, rows = observed.traces['residual'].raw(seen.begin, seen.end)
    found = autocorrelation(_scaled(rows[:, 2 * place], rows[:, 2 * place + 1]))
    return _panel('residual', variable, curves) | {
        'correlation': {
            'values': numbers(found.values), 'bound': number(found.bound),
            'white': found.white, 'words': found.words,
        }
    }  # fmt: skip


def _scaled(residuals: Array, sd: Array) -> Array:
    """Return residuals (K,) over their standard deviations, where these are known of all."""
    return residuals / sd if (sd[np.isfinite(residuals)] > 0.0).all() else residuals


def _curve(role: str, cut: Extremes, place: int, seen: Seen) -> list[dict[str, Any]]:
    """Return one curve of a role; none where nothing was heard."""
    if place >= cut.low.shape[1] or not np.isfinite(cut.low[:, place]).any():
        return []
    stamps, values = cut.column(place)
    return [{'role': role, 't': seen.seconds(stamps), 'v': numbers(values)}]


def _band(role: str, cut: Extremes, place: int, seen: Seen) -> list[dict[str, Any]]:
    """Return one curve with its band of +-2 sd, of a bucket as far as it reaches in it."""
    curves = _curve(role, cut, BAND * place, seen)
    lower, upper = cut.low[:, BAND * place + 1 :], cut.high[:, BAND * place + 2 :]
    for curve in curves:
        curve['band'] = _edges(cut.high_at[:, BAND * place], lower[:, 0], upper[:, 0], seen)
    return curves


def _edges(stamps: IntArray, lower: Array, upper: Array, seen: Seen) -> dict[str, Any]:
    """Return a band by its edges (K,) at stamps (K,)."""
    order = np.argsort(stamps, kind='stable')
    return {
        't': seen.seconds(stamps[order]),
        'lower': numbers(lower[order]),
        'upper': numbers(upper[order]),
    }


def _jump(jump: HeardJump, seen: Seen) -> dict[str, Any]:
    sizes = ', '.join(
        f'{name} {size:+.3g} \N{PLUS-MINUS SIGN} {2.0 * jump.stddev.get(name, math.nan):.2g}'
        for name, size in jump.sizes.items()
    )
    return {
        't': (jump.stamp - seen.origin) / 1e9, 'names': list(jump.sizes), 'words': sizes,
        'probability': number(jump.probability),
        'probable': probability_words(jump.probability) or 'probability not known',
        'retracted': jump.retracted,
    }  # fmt: skip
