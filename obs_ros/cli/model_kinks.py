"""Report on the kinks of a model: the lines of its dynamics that switch along rollouts."""

from collections.abc import Mapping

import numpy as np

from obs_ros.cli.model_trial import Trial, candidates
from obs_ros.core.kinks import Kink, kinks_of
from obs_ros.core.recorder import Untraceable

MOST = 3  # places told of one line


def kinks(trial: Trial, values: Mapping[str, float]) -> list[str]:
    """Return a line for each of the model's that switches in the trial, or in other candidates'.

    `values` replaces nominal ones by name.
    """
    model = trial.model
    try:
        found = kinks_of(model)
    except Untraceable as error:
        return [f'kinks: not looked for, as dynamics cannot be recorded: {error}']
    if not found.kinks:
        return []
    x0, p = candidates(model, values)
    with np.errstate(all='ignore'):
        states, _ = trial.kernels.trajectories(trial.grid, x0, p)
    t, u, own = trial.grid.clock, trial.record.u, trial.own_parameters
    met = np.array([found.met(t, states[:, :, k], u, p[:own, k]) for k in range(x0.shape[1])])
    lines: dict[tuple[str, int], list[int]] = {}
    for s in np.flatnonzero(met.any(axis=0)):
        kink = found.kinks[s]
        lines.setdefault((kink.file, kink.line), []).append(int(s))
    return [_line([found.kinks[s] for s in each], met[:, each]) for each in lines.values()]


def _line(kinks: list[Kink], met: np.ndarray) -> str:
    where = list(dict.fromkeys(kink.where for kink in kinks))
    shown = ', '.join(where[:MOST]) + (', ...' if len(where) > MOST else '')
    own = 'this rollout and ' if met[0].any() else ''
    others = int(met[1:].any(axis=1).sum())
    return f'kink: {kinks[0].place}, where {shown}; met in {own}{others} of {len(met) - 1} others'
