"""The picture of a study: outcomes, forecast skill and scatter, variant beside variant."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from obs_ros.core.estimate import Outcome
from obs_ros.core.texts import one_line
from obs_ros.core.typing import Array
from obs_ros.replay.extras import require
from obs_ros.replay.panels import COLOURS, STYLE
from obs_ros.studies.scores import Scores, outcomes, parameters

PICTURE = 'variants.png'
MOST = 40  # variants: more rows would not be read
LONGEST = 60  # characters of a variant beside its row
# The better an outcome, the calmer its colour.
OUTCOME_COLOURS = {
    Outcome.CONVERGED: '#2d7f46', Outcome.APPROXIMATE: '#8fbf6a', Outcome.AT_BOUND: '#d9b648',
    Outcome.NOT_IDENTIFIABLE: '#7d9cc4', Outcome.MODEL_MISMATCH: '#c4561a',
}  # fmt: skip
OTHER_COLOUR = '#8a8a8a'
WORST = -1.0  # the least skill that is drawn: below it a forecast is of no use anyway


def draw(scores: Mapping[str, Scores], folder: Path) -> list[str]:
    """Write the picture, and return the names of what was written: nothing without estimates.

    Raises MissingPackageError without Matplotlib.
    """
    require('matplotlib', 'drawing').use('Agg')
    plt = require('matplotlib.pyplot', 'drawing')
    if not outcomes(list(scores.values())):
        return []
    with plt.rc_context(STYLE):
        figure = compared(plt, dict(list(scores.items())[:MOST]))
    figure.savefig(folder / PICTURE, dpi=120, metadata={'Software': None})
    plt.close(figure)
    return [PICTURE]


def compared(plt: Any, scores: Mapping[str, Scores]) -> Any:
    """Return the figure; `plt` is matplotlib.pyplot."""
    found = list(scores.values())
    scattered = parameters(found)
    skilled = any(np.isfinite(each.skill).any() for each in found)
    kinds = 1 + skilled + bool(scattered)
    figure, axes = plt.subplots(
        1, kinds, figsize=(3.2 + 3.0 * kinds, 1.6 + 0.34 * len(found)), sharey=True, squeeze=False,
        layout='constrained',
    )  # fmt: skip
    left = iter(axes[0])
    _shares(next(left), found)
    if skilled:
        ax = next(left)
        points = [np.maximum(each.skill, WORST) for each in found]
        _strips(ax, points, COLOURS[0])
        ax.axvline(0.0, color='0.6', linestyle=':', linewidth=1.0)
        ax.set_title('Forecast skill by recording', loc='left')
    if scattered:
        ax = next(left)
        for k, name in enumerate(scattered):
            shift = 0.5 * ((k + 0.5) / len(scattered) - 0.5)
            points = [each.scatter(name) for each in found]
            _strips(ax, points, COLOURS[k % len(COLOURS)], shift, name)
        ax.axvline(1.0, color='0.6', linestyle=':', linewidth=1.0)
        ax.set_xscale('log')
        ax.set_title('Scatter over sd by recording', loc='left')
        ax.legend(frameon=False, fontsize=7)
    first = axes[0, 0]
    first.set_yticks(range(len(found)), [one_line(name, LONGEST) for name in scores])
    first.invert_yaxis()
    return figure


def _shares(ax: Any, found: Sequence[Scores]) -> None:
    """Draw the shares of outcomes as bars that reach 100 %."""
    begin = np.zeros(len(found))
    places = np.arange(len(found))
    for outcome in sorted(map(Outcome, outcomes(found)), key=list(Outcome).index):
        share = np.array([100.0 * each.share(outcome) for each in found])
        colour = OUTCOME_COLOURS.get(outcome, OTHER_COLOUR)
        ax.barh(places, share, left=begin, color=colour, height=0.7, label=outcome.value)
        begin += share
    ax.set_xlim(0.0, 100.0)
    ax.set_title('Outcomes (%)', loc='left')
    ax.legend(loc='upper left', bbox_to_anchor=(0.0, -0.08), ncols=2, frameon=False, fontsize=7)


def _strips(
    ax: Any, points: Sequence[Array], colour: str, shift: float = 0.0, label: str | None = None
) -> None:
    """Draw a dot for each recording, and a line at the median of each variant."""
    for row, values in enumerate(points):
        known = values[np.isfinite(values)]
        if known.size:
            at = row + shift
            ax.plot(known, np.full(known.size, at), linestyle='', marker='o', markersize=3,
                    color=colour, alpha=0.35, markeredgewidth=0, label=label)  # fmt: skip
            ax.plot([np.median(known)] * 2, [at - 0.18, at + 0.18], color=colour, linewidth=2.0)
            label = None
