"""The demo's picture: levels and valve openings, true and estimated."""

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from demo.jumps import merged
from demo.recorder import Recorder, Vector, intervals_of

COLOURS = ('tab:blue', 'tab:orange', 'tab:green')


def draw(recorder: Recorder, path: str) -> None:
    """Write true levels and openings, what was measured and what was estimated, to a PNG."""
    figure, (levels, openings) = plt.subplots(2, 1, figsize=(10, 7.5), sharex=True)
    ends = sorted(recorder.received['parameters'])
    jumps = merged(recorder.jumps)
    _draw_levels(levels, recorder)
    _draw_openings(openings, recorder)
    for axes in (levels, openings):
        for moment, _ in jumps:
            axes.axvline(moment, color='tab:red', linestyle='--', linewidth=1)
        axes.grid(alpha=0.3)
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small')
    for moment, jump in jumps:
        openings.annotate(
            f'found at {moment:.2f} s:\n' + str(jump).replace(', ', '\n'),
            (moment, 0.03), xytext=(6, 0), textcoords='offset points',
            color='tab:red', fontsize='small',
        )  # fmt: skip
    openings.set_xlim(0, ends[-1] / 1e9 * 1.01)
    openings.set_xlabel('plant time (s)')
    levels.set_title('Three tanks: hidden level and valve openings from two measured levels')
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_levels(axes: Axes, recorder: Recorder) -> None:
    truth, output = recorder.received['truth'], recorder.received['output']
    for name, colour in zip(('h1', 'h2', 'h3'), COLOURS, strict=True):
        _curve(axes, truth, name, color=colour, label=f'{name}, true')
        if any(name in values for values in output.values()):
            _curve(
                axes, dict(list(output.items())[::40]), name, color=colour, marker='.',
                linestyle='', alpha=0.4, label=f'{name}, measured (1 of 40)',
            )  # fmt: skip
        _draw_estimates(axes, recorder, 'state', name, colour)
    axes.set_ylabel('level (cm)')


def _draw_openings(axes: Axes, recorder: Recorder) -> None:
    for name, colour in zip(('p1', 'p2', 'p3'), COLOURS, strict=True):
        _curve(axes, recorder.received['true_parameters'], name, color=colour,
               linewidth=1, label=f'{name}, true')  # fmt: skip
        _draw_estimates(axes, recorder, 'parameters', name, colour)
    axes.set_ylabel('valve opening (1)')
    axes.set_ylim(0, 1.08)


def _draw_estimates(axes: Axes, recorder: Recorder, topic: str, name: str, colour: str) -> None:
    """Draw estimates with their 95 % intervals, which may reach further to one side."""
    stamps = sorted(recorder.received[topic])
    value = np.array([recorder.received[topic][stamp][name] for stamp in stamps])
    ends = np.array([intervals_of(recorder, topic, stamp)[name] for stamp in stamps])
    seconds = np.array(stamps) / 1e9
    reach = np.nan_to_num(np.maximum([value - ends[:, 0], ends[:, 1] - value], 0.0))
    axes.errorbar(
        seconds, value, yerr=reach, color=colour, marker='o',
        markersize=4, linestyle='', markerfacecolor='none', capsize=2, linewidth=1,
        label=f'{name}, estimated, 95 %',
    )  # fmt: skip
    lost = np.isnan(ends).any(axis=1)
    axes.plot(seconds[lost], value[lost], 'x', color=colour, markersize=7)


def _curve(axes: Axes, history: dict[int, Vector], name: str, **style: object) -> None:
    stamps = sorted(history)
    axes.plot([s / 1e9 for s in stamps], [history[s][name] for s in stamps], **style)
