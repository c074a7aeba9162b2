"""Pictures of windows in sequence; needs Matplotlib."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.report import panels
from benchmarks.sequence.contestants import EKF, OURS
from benchmarks.sequence.jumps import found
from benchmarks.sequence.plants import PLANTS, Run
from benchmarks.sequence.run import Measured
from benchmarks.sequence.scenes import Scene, run_of
from benchmarks.sequence.scores import coverage
from benchmarks.sequence.track import Track, tracked

COLOURS = {
    OURS: 'tab:blue',
    'no prior': 'tab:orange',
    'Tikhonov': 'tab:green',
    'MAP arrival cost': 'tab:red',
    EKF: 'tab:purple',
}
SNR_COLOURS = {'tanks 40 dB': 'tab:green', 'tanks 20 dB': 'tab:blue', 'tanks 0 dB': 'tab:orange'}
LEAST_COVERAGE = 0.55  # drawn
STORY_WINDOWS, STORY_SNR = 12, 20.0
Z = np.linspace(-4.0, 4.0, 201)


def draw_story(seed: int) -> Any:
    """Draw one run: parameters and hidden level beside the truth, ours and windows alone."""
    scene = Scene('tanks', STORY_SNR, 'jump and rest', seed, STORY_WINDOWS)
    run = run_of(scene)
    figure, grid = panels(4, 2, (13.0, 9.0), sharex=True, sharey='row')
    for column, contestant in zip(grid.T, (OURS, 'no prior'), strict=True):
        track = tracked(scene, False, contestant)
        for i, axes in enumerate(column[:3]):
            truth = run.parameters.before(run.t)[:, i]
            _told(axes, run, truth, track, track.p[:, i], track.p_sd[:, i], COLOURS[contestant])
            axes.set_ylim(-0.02, 1.02)
        level, sd = 100.0 * track.x[:, 2], 100.0 * track.x_sd[:, 2]
        _told(column[3], run, run.x[:, 2], track, level, sd, COLOURS[contestant])
        top = 1.2 * float(run.x[run.t > run.plant.duration, 2].max())
        column[3].set(ylim=(0.0, top), xlabel='t (s)')
        column[0].set_title(f'{contestant}: a window of 300 s every 50 s', fontsize=11)
    for axes, name in zip(grid[:, 0], ('p1', 'p2', 'p3', 'h3 (cm), hidden'), strict=True):
        axes.set_ylabel(name)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside lower center', ncols=len(labels), fontsize=9)
    figure.suptitle(
        f'p1 jumps, later the feeds rest (shaded): {STORY_SNR:g} dB, seed {seed}', fontsize=12
    )
    return figure


def _told(
    axes: Any, run: Run, truth: np.ndarray, track: Track, value: np.ndarray, sd: np.ndarray,
    colour: str,
) -> None:  # fmt: skip
    """Draw one value against time."""
    rest = 7.0 * run.plant.duration
    axes.axvspan(rest, float(run.t[-1]), color='0.93', zorder=0)
    axes.plot(run.t, truth, 'k', lw=1.0, label='truth')
    axes.fill_between(
        track.end, value - 2.0 * sd, value + 2.0 * sd, color=colour, alpha=0.3, lw=0,
        label='± 2 sd',
    )  # fmt: skip
    axes.plot(track.end, value, '.-', color=colour, ms=4, lw=0.8, label='estimate')
    alarms = track.end[track.alarms > 0]
    axes.vlines(
        alarms, 0.0, 1.0, transform=axes.get_xaxis_transform(), color='tab:red', ls='--', lw=1.0,
        label='alarm',
    )  # fmt: skip
    axes.grid(alpha=0.3)
    axes.set_xlim(run.plant.duration, float(run.t[-1]))


def draw_calibration(measured: Measured) -> Any:
    """Draw coverage by cell and contestant, and how ours's errors over sd are distributed."""
    figure, ((bars, histogram),) = panels(1, 2, (13.5, 4.6), width_ratios=(2.0, 1.0))
    cells = list(dict.fromkeys(cell for cell, _ in measured.clean))
    contestants = list(dict.fromkeys(contestant for _, contestant in measured.clean))
    middle, width = np.arange(len(cells)), 0.8 / len(contestants)
    for i, contestant in enumerate(contestants):
        shares = [coverage(measured.clean[cell, contestant], 'p') for cell in cells]
        bars.errorbar(
            middle + (i + 0.5) * width - 0.4, [s.value for s in shares],
            [s.margin for s in shares], fmt='o', color=COLOURS[contestant], ms=5, capsize=2,
            label=contestant,
        )  # fmt: skip
    bars.axhline(0.95, color='k', ls='--', lw=1)
    for edge in middle[1:] - 0.5:
        bars.axvline(edge, color='0.85', lw=1)
    bars.set_xticks(middle, [cell.replace(', ', '\n') for cell in cells], fontsize=8)
    bars.set(ylabel='coverage of 95 % intervals', title='parameters, clean sequences', xlim=(
        -0.5, len(cells) - 0.5))  # fmt: skip
    bars.grid(axis='y', alpha=0.3)
    bars.set_ylim(LEAST_COVERAGE, 1.02)
    bars.legend(fontsize=9, loc='lower left', ncols=3)
    _histogram(histogram, measured)
    return figure


def _histogram(axes: Any, measured: Measured) -> None:
    edges = np.linspace(-4.0, 4.0, 33).tolist()
    for plant, colour in (('tanks', 'tab:blue'), ('lag', 'tab:orange')):
        own = [
            track
            for (cell, contestant), tracks in measured.clean.items()
            if contestant == OURS and cell.startswith(plant)
            for track in tracks
        ]
        ratios = np.concatenate([(track.errors / track.deviations).ravel() for track in own])
        finite = ratios[np.isfinite(ratios)]
        axes.hist(
            np.clip(finite, edges[0], edges[-1]), edges, density=True, histtype='step',
            color=colour, lw=1.5, label=f'ours, {plant}: {finite.size} values',
        )  # fmt: skip
    axes.plot(Z, np.exp(-0.5 * Z**2) / np.sqrt(2.0 * np.pi), 'k--', lw=1, label='normal')
    axes.set(xlabel='error / sd', ylabel='density', title='parameters and end states')
    axes.set_ylim(0.0, 1.45 * axes.dataLim.ymax)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9, loc='upper center')


def draw_jumps(tracks: Mapping[str, Sequence[Track]]) -> Any:
    """Draw the error of each jump's time against its size."""
    figure, (both,) = panels(1, 2, (12.0, 4.6))
    for cell, own in tracks.items():
        axes = both[0 if cell in SNR_COLOURS else 1]
        colour = SNR_COLOURS.get(cell, 'tab:blue')
        step = PLANTS[own[0].scene.plant].step
        jumps = [found(track) for track in own]
        right = [jump for jump in jumps if jump.right]
        axes.plot(
            [jump.size for jump in right], [max(jump.time_error, 1e-3 * step) for jump in right],
            'o', color=colour, ms=4, alpha=0.6, mec='none',
            label=f'{cell}: {len(right)} of {len(jumps)} found rightly',
        )  # fmt: skip
        rank = 0.90 + 0.035 * (list(SNR_COLOURS).index(cell) if cell in SNR_COLOURS else 1)
        rest = [jump for jump in jumps if not jump.right]
        axes.plot(
            [jump.size for jump in rest], np.full(len(rest), rank), 'x', color=colour, ms=5,
            transform=axes.get_xaxis_transform(),
        )  # fmt: skip
    for axes, title in zip(both, ('three tanks', 'first-order lag'), strict=True):
        axes.set(xscale='log', yscale='log', xlabel='size of the jump (box)')
        axes.set_title(f'{title} (crosses: not found in time, or not rightly)', fontsize=10)
        low, high = axes.get_ylim()
        axes.set_ylim(low / 3.0, 8.0 * high)
        axes.set_ylabel('error of its time (s)')
        axes.set_xticks([0.03, 0.05, 0.1, 0.2, 0.4], ['.03', '.05', '.1', '.2', '.4'])
        axes.set_xticks([], minor=True)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=9, loc='lower left')
    return figure
