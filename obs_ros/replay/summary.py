"""The summary of a replay, a page of Markdown."""

from collections.abc import Iterator

import numpy as np

from obs_ros.core.drifting import remedy
from obs_ros.core.periods import together, within
from obs_ros.core.texts import LONGEST, one_line
from obs_ros.interface.parameters import walk_unit
from obs_ros.replay.cells import (
    cell,
    figure,
    largest,
    median,
    table,
    unit,
    with_interval,
)
from obs_ros.replay.comparison import Other, comparison
from obs_ros.replay.engine import Account
from obs_ros.replay.forecast import NEAR
from obs_ros.replay.history import FORECASTS
from obs_ros.replay.recording import Recording
from obs_ros.replay.settings import Setup

SHOWN = 50  # jumps, notes and combinations at most, so that the page stays one


def summary(
    name: str,
    setup: Setup,
    account: Account,
    recording: Recording,
    *,
    deadline: bool,
    other: Other | None = None,
) -> str:
    """Return the page; `name` is that of the recording, `other` stands beside the account."""
    parts = [
        f'# Replay of {one_line(name, LONGEST)}',
        *_head(setup, account, deadline),
        *_outcomes(account),
        *_estimates(account),
        *_jumps(account),
        *_misfit(account),
        *_process_noise(account),
        *_scatter(account),
        *([] if other is None else comparison(setup, account, other)),
        *_samples(account, recording),
    ]
    return '\n\n'.join(parts) + '\n'


def _head(setup: Setup, account: Account, deadline: bool) -> Iterator[str]:
    values = setup.values
    facts = [f'model `{setup.model.name}`', f'observer `{values["observer"]}`']
    if account.horizon is not None:
        period = values['window.period'] or values['window.duration']
        facts.append(f'windows of {values["window.duration"]:g} s, one every {period:g} s')
    facts.append(f'seed {values["seed"]}')
    if account.horizon is not None:
        facts.append(f'deadline {values["deadline"]:g} s' if deadline else 'no deadline')
    yield f'{"; ".join(facts)}.'
    yield (
        f'{account.recorded:.6g} s of recording, {account.samples} samples and '
        f'{len(account.history)} estimates in {account.wall_time:.3g} s: '
        f'**{account.speed:.3g} times real time**; before that, {account.compile_time:.2g} s to '
        'compile the model.'
    )


def _outcomes(account: Account) -> Iterator[str]:
    history = account.history
    yield '## Outcomes'
    if not len(history):
        yield (
            'There was no estimate: no window closed. Both streams must reach the end of the first '
            'one; is `window.duration` shorter than the recording?'
            if account.horizon is not None
            else 'There was no estimate: no output came with every input known.'
        )
        return
    yield table(
        ('outcome', 'estimates', 'the last of them says'),
        [
            (f'`{outcome}`', f'{count}', cell(history.messages[outcome]))
            for outcome, count in history.outcomes.most_common()
        ],
    )
    if history.weak:
        lines = [
            f'- {words}: {count} estimates' for words, count in history.weak.most_common(SHOWN)
        ]
        yield 'Left undetermined by windows:\n\n' + '\n'.join(lines)


def _estimates(account: Account) -> Iterator[str]:
    history = account.history
    if not len(history):
        return
    values, deviations, lower, upper = map(history.rows, ('values', 'deviations', 'lower', 'upper'))
    n = len(history.model.states)
    for title, first, variables in (
        ('Parameters', n, history.model.parameters),
        (
            'States' if account.horizon is None else 'States, at the end of each window',
            0,
            history.model.states,
        ),
    ):
        if not variables:
            continue
        rows = []
        for place, variable in enumerate(variables, first):
            value, deviation = values[:, place], deviations[:, place]
            known = np.flatnonzero(np.isfinite(value))
            if not known.size:
                rows.append((variable.name, unit(variable), *['none'] * 6))
                continue
            ends = [
                with_interval(value[k], lower[k, place], upper[k, place])
                for k in (known[0], known[-1])
            ]
            period = variable.period or 0.0
            spread = np.quantile(together(value[known], period), (0.5, 0.05, 0.95))
            middle, low, high = within(spread, np.asarray(period))
            rows.append((
                variable.name, unit(variable), *ends, figure(middle),
                figure(median(deviation)), f'{figure(low)} to {figure(high)}',
                f'{np.isfinite(deviation).sum()} of {len(history)}',
            ))  # fmt: skip
        yield f'## {title}'
        yield table(
            ('', 'unit', 'first', 'last', 'median', 'median sd', 'estimates, 5 to 95 %', 'with sd'),
            rows,
        )
    yield (
        'First and last are with their 95 % intervals; `?`: not determined or withheld. Medians '
        'are over the estimates. Where estimates vary much more than their standard deviations '
        'say, the parameters move or the model leaves something out.'
    )


def _jumps(account: Account) -> Iterator[str]:
    history = account.history
    if account.horizon is None:
        return
    back = f', {history.retraction_count} taken back' if history.retraction_count else ''
    yield f'## Jumps: {history.jump_count}{back}'
    lines = []
    for jump in history.jumps[:SHOWN]:
        others = f' (or: {"; ".join(jump.alternatives)})' if jump.alternatives else ''
        lines.append(f'- {jump}{others}')
    if (more := history.jump_count + history.retraction_count - len(lines)) > 0:
        lines.append(f'- and {more} more, in the table of estimates')
    yield '\n'.join(lines) if lines else 'No window showed one.'
    if history.drifting:
        counts = [f'{name} in {count} estimates' for name, count in history.drifting.most_common()]
        yield f'Drifting: {", ".join(counts)}; {remedy(sorted(history.drifting))}.'


def _misfit(account: Account) -> Iterator[str]:
    history = account.history
    if not len(history):
        return
    if account.horizon is None:
        yield '## Innovations'
        rms = history.rows('rms')[:, 0]
        known = rms[np.isfinite(rms)]
        if not known.size:
            yield 'The observer has no innovations.'
            return
        yield (
            f'Root mean square of the innovation over all outputs: {figure(median(rms))} in the '
            f'median, {figure(np.quantile(known, 0.95))} at 95 %, {figure(known.max())} at most.'
        )
        return
    yield '## Residuals and forecasts'
    residuals, *forecast = (history.rows(kind) for kind in ('residuals', *FORECASTS))
    forecasts, held, near, near_held = forecast
    judged = np.isfinite(held).any(axis=1) | ~np.isnan(forecasts).all(axis=1)
    rows = []
    for place, variable in enumerate(history.model.outputs):
        figures = [
            figure(column[:, place])
            for column, figure in (
                (residuals, median), (residuals, largest), (near, median), (near_held, median),
                (forecasts, median), (held, median), (forecasts, largest),
            )
        ]  # fmt: skip
        rows.append((variable.name, unit(variable), *map(figure, figures)))
    yield table(
        ('output', 'unit', 'residual, median', 'largest', 'near forecast error, median',
         'last value held', 'forecast error, median', 'last value held', 'largest'), rows,
    )  # fmt: skip
    yield (
        f'Root mean squares over a window. A forecast runs the model on from an estimate through '
        f'the next {account.horizon:g} s, whose outputs that estimate has not seen, with the '
        f'inputs as they came: {judged.sum()} of {len(history)} could be compared; near is its '
        f'first {NEAR * account.horizon:.3g} s. Beside each stands the median error of the last '
        'output held instead; a model that is worth having is better than that.'
    )


def _process_noise(account: Account) -> Iterator[str]:
    history = account.history
    walks, skill = history.rows('walks'), history.rows('skill')
    if not (walks > 0.0).any() and np.isnan(skill).all():
        return
    yield '## Process noise and forecast skill'
    rows = []
    for place, variable in enumerate(history.model.variables):
        found = walks[walks[:, place] > 0.0, place]
        if found.size:
            count = f'{found.size} of {len(history)}'
            rows.append((variable.name, walk_unit(variable), count, figure(median(found)),
                         figure(largest(found))))  # fmt: skip
    if rows:
        yield table(('walk of', 'unit', 'windows', 'median', 'largest'), rows)
    told = skill[np.isfinite(skill)]
    if told.size:
        yield (
            f'Forecast skill, 1 - MSE / MSE of the last value held: {figure(median(told))} in the '
            f'median of {told.size} windows, {figure(told[-1])} in the last; at 0 a model is no '
            'better than holding the last value.'
        )


def _scatter(account: Account) -> Iterator[str]:
    history, rows = account.history, []
    for column, variable in zip(history.rows('scatter').T, history.model.parameters, strict=True):
        factors = column[np.isfinite(column)]
        if factors.size:
            rows.append((variable.name, figure(median(factors)), figure(factors[-1])))
    if rows:
        yield '## Scatter of disjoint windows over their standard deviations'
        yield table(('', 'median', 'last'), rows)
        yield (
            'At 1 the standard deviations hold. Above it, those published are raised by it: the '
            'model leaves out what differs from window to window, or the parameters move.'
        )


def _samples(account: Account, recording: Recording) -> Iterator[str]:
    counts = {**recording.refused, **account.counts}
    if account.failed:
        counts['failed'] = account.failed
    yield '## Dropped, mended and skipped'
    found = [(f'`{reason}`', f'{count}') for reason, count in counts.items() if count]
    yield table(('reason', 'count'), found) if found else 'Nothing.'
    notes = [*recording.remarks, *account.notes]
    if notes:
        lines = [f'- {cell(note)}' for note in notes[:SHOWN]]
        yield '\n'.join(lines)
