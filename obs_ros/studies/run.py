"""One recording replayed under one set of parameters, to a result."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from obs_ros.core.estimate import Estimate
from obs_ros.core.model import names
from obs_ros.replay.engine import Account, replay
from obs_ros.replay.history import FORECASTS
from obs_ros.replay.recording import Recording, Source, open_recording
from obs_ros.replay.settings import setup
from obs_ros.replay.writers import columns, row
from obs_ros.studies.keys import content
from obs_ros.studies.result import Collector, Result

# Beside the columns of `estimates.csv`: root mean squares by output, from `History`.
ERRORS = dict(zip(FORECASTS, ('forecast_rms', 'held_rms', 'near_forecast_rms', 'near_held_rms'),
                  strict=True))  # fmt: skip


def replayed(source: Source, digest: str, given: Mapping[str, Any], deadline: bool) -> bytes:
    """Return the result of a run, as bytes; `digest` is that of the recording (`keys.content`).

    Raises ValueError, OSError or ImportError, written for the user, for a recording that cannot be
    read or is not the one that is meant, and for parameters that are wrong.
    """
    if content(source.path) != digest:
        raise ValueError(f'{source.path} is another recording here, or was changed meanwhile')
    chosen = setup(given)
    recording = open_recording(source, chosen)
    rows = Collector(columns(chosen.model))

    def take(estimate: Estimate, skipped: int) -> None:
        rows.add(row(estimate, chosen.model, skipped))

    account = replay(chosen, recording, deadline=deadline, take=take)
    table = {**rows.columns(), **_judged(account)}
    return Result(table, _facts(account, recording)).to_bytes()


def _judged(account: Account) -> dict[str, Any]:
    """Return what the history tells of each estimate, as columns (K,)."""
    history = account.history
    found: dict[str, Any] = {}
    outputs, parameters = names(history.model.outputs), names(history.model.parameters)
    for kind, called in ERRORS.items():
        found |= _columns(called, outputs, history.rows(kind).T)
    found |= _columns('walk', names(history.model.variables), history.rows('walks').T)
    found['forecast_skill'] = history.rows('skill')[:, 0]
    return {**found, **_columns('scatter_over_sd', parameters, history.rows('scatter').T)}


def _columns(called: str, variables: Iterable[str], rows: Any) -> dict[str, Any]:
    return {f'{called}.{name}': column for name, column in zip(variables, rows, strict=True)}


def _facts(account: Account, recording: Recording) -> dict[str, Any]:
    history = account.history
    plain = ('compile_time', 'wall_time', 'samples', 'horizon', 'failed', 'notes', 'recorded')
    return {
        **{name: getattr(account, name) for name in plain},
        'counts': {**recording.refused, **account.counts},
        'remarks': list(recording.remarks),
        'jumps': history.jump_count,
        'retracted': history.retraction_count,
        'every_sd': int(np.isfinite(history.rows('deviations')).all(axis=1).sum()),
    }


def at(source: Source, path: Any) -> Source:
    """Return the source of another recording that is read alike."""
    return dataclasses.replace(source, path=path)
