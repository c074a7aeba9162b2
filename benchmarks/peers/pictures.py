"""Picture of the peers' times; needs Matplotlib."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.peers.registry import OURS, PEERS
from benchmarks.peers.report import by_case, by_peer, solved_share
from benchmarks.peers.run import Measured
from benchmarks.report import panels


def draw_times(results: Sequence[Measured]) -> Any:
    """Draw process times as bars; pale where not all is solved."""
    cases = by_case(results)
    figure, grid = panels(1, len(cases), (6.0 * len(cases), 5.0), sharey=True)
    for (case, results_of), axes in zip(cases.items(), grid[0], strict=True):
        peers = by_peer(results_of)
        for place, (name, own) in enumerate(peers.items()):
            milliseconds = 1e3 * float(np.median([one.seconds for one in own]))
            colour = 'tab:green' if name.startswith(OURS) else 'tab:blue'
            solved = f'{sum(one.reached for one in own)}/{len(own)}'
            pale = 1.0 if solved_share(own) == 1.0 else 0.35
            if PEERS[name].filters:
                colour, solved, pale = 'tab:gray', 'end only', 1.0
            axes.barh(place, milliseconds, color=colour, alpha=pale)
            label = f'{milliseconds:.3g}  ({solved})'
            axes.text(1.1 * milliseconds, place, label, va='center', fontsize=8)
        axes.set_yticks(range(len(peers)), list(peers))
        axes.set(xscale='log', xlabel='median process time (ms)', title=case)
        axes.set_xlim(1.0, 12.0 * axes.get_xlim()[1])
        axes.grid(axis='x', alpha=0.3)
    grid[0, 0].invert_yaxis()
    figure.suptitle('In brackets: windows solved; pale: not all of them')
    return figure
