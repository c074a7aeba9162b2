"""The demo's picture: levels and valve openings, true and estimated."""

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from demo.recorder import Recorder, Vector

COLOURS = ('tab:blue', 'tab:orange', 'tab:green')


def draw(recorder: Recorder, path: str) -> None:
    """Write true levels and openings, what was measured and what was estimated, to a PNG."""
    figure, (levels, openings) = plt.subplots(2, 1, figsize=(9, 7), sharex=True)
    ends = sorted(recorder.received['parameters'])
    _draw_levels(levels, recorder, ends)
    _draw_openings(openings, recorder, ends)
    for axes in (levels, openings):
        for end in ends[:-1]:
            axes.axvline(end / 1e9, color='0.6', linestyle=':', linewidth=1)
        axes.grid(alpha=0.3)
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small')
    openings.set_xlim(0, ends[-1] / 1e9 * 1.01)
    openings.set_xlabel('plant time (s); dotted: the valves move, a new window starts')
    levels.set_title('Three tanks: levels and valve openings from two measured levels')
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_levels(axes: Axes, recorder: Recorder, ends: list[int]) -> None:
    truth, output = recorder.received['truth'], recorder.received['output']
    for name, colour in zip(('h1', 'h2', 'h3'), COLOURS, strict=True):
        _curve(axes, truth, name, color=colour, label=f'{name}, true')
        if any(name in values for values in output.values()):
            _curve(
                axes, dict(list(output.items())[::40]), name, color=colour, marker='.',
                linestyle='', alpha=0.4, label=f'{name}, measured (1 of 40)',
            )  # fmt: skip
        estimates = {stamp: recorder.received['state'][stamp] for stamp in ends}
        _curve(
            axes, estimates, name, color=colour, marker='o', markersize=9, linestyle='',
            markerfacecolor='none', markeredgewidth=2, label=f'{name}, estimated',
        )  # fmt: skip
    axes.set_ylabel('level (cm)')


def _draw_openings(axes: Axes, recorder: Recorder, ends: list[int]) -> None:
    for name, colour in zip(('p1', 'p2', 'p3'), COLOURS, strict=True):
        _curve(axes, recorder.received['true_parameters'], name, color=colour,
               linewidth=1, label=f'{name}, true')  # fmt: skip
        start = 0.0
        for i, end in enumerate(ends):
            value = recorder.received['parameters'][end][name]
            axes.plot([start / 1e9, end / 1e9], [value, value], color=colour, linewidth=6,
                      alpha=0.35, solid_capstyle='butt',
                      label=f'{name}, estimated' if i == 0 else None)  # fmt: skip
            start = end
    axes.set_ylabel('valve opening (1)')
    axes.set_ylim(0, 1.08)


def _curve(axes: Axes, history: dict[int, Vector], name: str, **style: object) -> None:
    stamps = sorted(history)
    axes.plot([s / 1e9 for s in stamps], [history[s][name] for s in stamps], **style)
