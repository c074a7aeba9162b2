"""The summary of a study, a page of Markdown that compares its variants."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from obs_ros.core.texts import LONGEST_NAME, one_line
from obs_ros.core.typing import Array
from obs_ros.replay.cells import cell, figure, median, table
from obs_ros.studies.scores import Scores, outcomes, parameters

SHOWN = 50  # recordings and failures at most, so that the page stays one
BLANK = ''


@dataclass(frozen=True)
class Findings:
    """All that the page tells: runs by variant, those without a result, and remarks.

    `missing` has recording, variant and why. `seconds` are those of all runs together; `about`
    tells the settings that do not vary.
    """

    recordings: int
    scores: Mapping[str, Scores]
    missing: Sequence[tuple[str, str, str]] = ()
    remarks: Sequence[str] = ()
    pictures: Sequence[str] = field(default_factory=list)
    seconds: float = 0.0
    about: str = ''


def page(found: Findings) -> str:
    """Return the page."""
    parts = [
        '# Study',
        *_head(found),
        *_outcomes(found.scores),
        *_forecasts(found.scores),
        *_scatter(found.scores),
        *(f'![{name}]({name})' for name in found.pictures),
        *_recordings(found.scores),
        *_missing(found.missing),
        *(['## Remarks', _lines(found.remarks)] if found.remarks else []),
    ]
    return '\n\n'.join(parts) + '\n'


def _head(found: Findings) -> Iterator[str]:
    runs = sum(len(each.runs) for each in found.scores.values())
    estimates = sum(each.estimates for each in found.scores.values())
    if found.about:
        yield f'{found.about}.'
    yield (
        f'{found.recordings} recordings, {len(found.scores)} variants: {runs} runs with '
        f'{estimates} estimates, which took {found.seconds:.3g} s of one core; '
        f'{len(found.missing) or "none"} without a result. All estimates stand in `estimates.csv`.'
    )


def _outcomes(scores: Mapping[str, Scores]) -> Iterator[str]:
    occurring = outcomes(list(scores.values()))
    if not occurring:
        yield 'There was no estimate: is `window.duration` shorter than the recordings?'
        return
    yield '## Outcomes'
    head = ('variant', 'estimates', *(f'`{each}`' for each in occurring), 'every sd given', 'jumps',
            'failed', 'time')  # fmt: skip
    yield table(head, (
        (cell(name), f'{each.estimates}', *(_percent(each.share(one)) for one in occurring),
         _percent(each.every_sd), f'{each.jumps}', f'{each.failed or BLANK}',
         f'{figure(each.seconds)} s')
        for name, each in scores.items()
    ))  # fmt: skip
    yield 'Shares are of all estimates of a variant; the time is that of a recording, the median.'


def _forecasts(scores: Mapping[str, Scores]) -> Iterator[str]:
    if all(np.isnan(each.skill).all() for each in scores.values()):
        return
    first, reference = next(iter(scores.items()))
    yield '## Forecast skill'
    rows = []
    for name, each in scores.items():
        better, of = each.better(reference)
        beside = BLANK if each is reference else f'{better} of {of}'
        rows.append((cell(name), *_spread(each.skill), beside))
    beside = f'better than {cell(first)}' if len(scores) > 1 else BLANK
    yield table(('variant', 'median', 'recordings, 5 to 95 %', beside), rows)
    yield (
        'Skill of a recording: 1 - MSE / MSE of the last value held, over all forecasts, averaged '
        'over the outputs. 1 is perfect, 0 no better than holding the last value. A forecast runs '
        'through the next `window.duration`: variants of it forecast over other times.'
    )


def _scatter(scores: Mapping[str, Scores]) -> Iterator[str]:
    known = parameters(list(scores.values()))
    if not known:
        return
    yield '## Scatter of disjoint windows over their standard deviations'
    yield table(('variant', *known), (
        (cell(name), *(figure(median(each.scatter(one))) for one in known))
        for name, each in scores.items()
    ))  # fmt: skip
    yield (
        'Medians over the recordings. At 1 the standard deviations hold; above it, those published '
        'are raised by it, since the model leaves something out or the parameters move.'
    )


def _recordings(scores: Mapping[str, Scores]) -> Iterator[str]:
    names = list(dict.fromkeys(name for each in scores.values() for name in each.runs))
    if len(names) < 2 or all(np.isnan(each.skill).all() for each in scores.values()):
        return
    yield '## Forecast skill by recording'
    rows = [
        (cell(one_line(name, LONGEST_NAME)),
         *(figure(each.runs[name].skill) if name in each.runs else BLANK
           for each in scores.values()))
        for name in names[:SHOWN]
    ]  # fmt: skip
    yield table(('recording', *map(cell, scores)), rows)
    if len(names) > SHOWN:
        yield f'And {len(names) - SHOWN} more, in the table of estimates.'


def _missing(missing: Sequence[tuple[str, str, str]]) -> Iterator[str]:
    if not missing:
        return
    yield f'## Without a result: {len(missing)}'
    rows = [(cell(recording), cell(variant), cell(why)) for recording, variant, why in missing]
    yield table(('recording', 'variant', 'why'), rows[:SHOWN])


def _spread(values: Array) -> tuple[str, str]:
    """Return the median, and where nine of ten lie; forecasts may have run away."""
    known = values[~np.isnan(values)]
    if not known.size:
        return figure(math.nan), BLANK
    low, high = np.quantile(known, (0.05, 0.95), method='nearest')
    return figure(median(known)), f'{figure(low)} to {figure(high)}'


def _percent(share: float) -> str:
    return f'{100.0 * share:.3g} %'


def _lines(texts: Sequence[str]) -> str:
    return '\n'.join(f'- {cell(text)}' for text in texts[:SHOWN])
