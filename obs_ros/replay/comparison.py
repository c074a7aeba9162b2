"""Two replays of one recording beside each other: as asked, and with one parameter changed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from obs_ros.core.parameter_spec import Value
from obs_ros.core.texts import quoted
from obs_ros.interface.settings import build_observer
from obs_ros.optimization.methods import METHODS
from obs_ros.replay.cells import cell, figure, median, table, unit
from obs_ros.replay.engine import Account
from obs_ros.replay.history import History
from obs_ros.replay.settings import Setup, setup

NONE = 'none'


@dataclass(frozen=True)
class Alternative:
    """The parameter `name` with another `value`, and all that a replay with it needs."""

    name: str
    value: Value
    setup: Setup

    def __str__(self) -> str:
        """Name the parameter with its value, as on the command line."""
        return f'{self.name}:={_shown(self.value)}'


@dataclass(frozen=True)
class Other:
    """An alternative, and how its replay went."""

    alternative: Alternative
    account: Account


def alternative(
    chosen: Setup, given: Mapping[str, Any], asked: tuple[str, Any] | None
) -> Alternative | None:
    """Return what to compare a replay of `chosen`, made of the parameters `given`, with.

    By default that is process noise off, or found where it is off; None for observers without.
    Raises ValueError for a parameter that there is not, that would change nothing, or that does not
    go together with the others.
    """
    values = chosen.values
    if asked is None:
        if 'process_noise' not in values or not METHODS[str(values['search.method'])].needs_squares:
            return None
        asked = 'process_noise', 'auto' if values['process_noise'] == 'off' else 'off'
    name, value = asked
    if name == 'model':
        raise ValueError('--compare: replay another model by itself, its estimates are others')
    other = setup({**given, name: value})
    if name not in other.values:
        raise ValueError(f'--compare: there is no parameter {quoted(name)}')
    if other.values[name] == values.get(name):
        raise ValueError(f'--compare: give {name} a value that the replay does not have already')
    build_observer(other.model, other.values)  # what does not go together is told at once
    return Alternative(name, other.values[name], other)


def comparison(chosen: Setup, account: Account, other: Other) -> Iterator[str]:
    """Yield the section: outcomes, deviations, residuals, forecasts and time, side by side."""
    name = other.alternative.name
    yield f'## With another {name}'
    accounts = (account, other.account)
    columns = [_column(each) for each in accounts]
    values = (chosen.values.get(name, NONE), other.alternative.value)
    yield table(
        ('', *(f'`{name}` {cell(_shown(value))}' for value in values)),
        [(row, *(column.get(row, '') for column in columns)) for row in columns[0] | columns[1]],
    )
    if account.horizon is None and other.account.horizon is None:
        yield 'The innovation is the median of root mean squares.'
        return
    yield (
        'Medians; in brackets the last output held instead. The residual is that of the outputs as '
        'the window explains them: with process noise one step ahead, without it from the initial '
        'state. So compare the forecasts, which no window has seen.'
    )


def _column(account: Account) -> dict[str, str]:
    """Return the figures of one replay by the heads of their rows."""
    history = account.history
    count = len(history)
    outcomes = [f'{outcome} {number}' for outcome, number in history.outcomes.most_common()]
    if account.failed:
        outcomes.append(f'failed {account.failed}')
    deviations = np.isfinite(history.rows('deviations')).all(axis=1)
    return {
        'outcomes': ', '.join(outcomes) or 'none',
        'every sd given': f'{deviations.sum()} of {count}',
        'jumps': f'{history.jump_count}',
        **({'jumps taken back': f'{history.retraction_count}'} if history.retraction_count else {}),
        **(_innovation(history) if account.horizon is None else _outputs(history)),
        'time': f'{account.wall_time:.3g} s',
    }


def _innovation(history: History) -> dict[str, str]:
    return {'innovation over all outputs': figure(median(history.rows('rms')[:, 0]))}


def _outputs(history: History) -> dict[str, str]:
    kinds = ('residuals', 'near', 'near_held', 'forecasts', 'held')
    errors = {kind: history.rows(kind) for kind in kinds}
    cells = {}
    for place, variable in enumerate(history.model.outputs):
        name = f'{variable.name}{f" ({unit(variable)})" if unit(variable) else ""}'
        medians = {kind: figure(median(rows[:, place])) for kind, rows in errors.items()}
        cells[f'residual of {name}'] = medians['residuals']
        for words, error, held in (
            ('an eighth of a window', 'near', 'near_held'), ('a window', 'forecasts', 'held'),
        ):  # fmt: skip
            cells[f'forecast of {name} over {words}'] = f'{medians[error]} ({medians[held]})'
    return cells


def _shown(value: Value) -> str:
    return str(list(value)) if isinstance(value, tuple) else str(value)
