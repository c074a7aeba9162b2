"""The time of a window beside that of the same window by another source tree."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.runner import ROOT, progress
from benchmarks.sequence.jumps_elsewhere.follow import solved
from benchmarks.sequence.jumps_elsewhere.rates import resampled, stacked
from benchmarks.sequence.jumps_elsewhere.scenes import Scene, run_of
from benchmarks.sequence.plants import Change
from benchmarks.trees import Tree
from obs_ros import Estimate
from obs_ros.core.typing import Array, BoolArray

_windows: Iterator[tuple[Estimate, float]] = iter(())  # of the scene that is timed here


class Timed(NamedTuple):
    """Process times (W,) in s of a run's warm windows, ours and theirs; which hold a jump."""

    scene: Scene
    ours: Array
    theirs: Array
    jumped: BoolArray


def begin(scene: Scene) -> tuple[tuple[Change, ...], int]:
    """Make a scene ready; return its jumps, and the number of its windows."""
    global _windows
    run = run_of(scene)
    records = run.records()
    _windows = solved(scene, records)
    return run.changes, len(records)


def step() -> float:
    """Solve the next window, and return its process time in s."""
    return next(_windows)[1]


def compare(scenes: Sequence[Scene], other: Path) -> list[Timed]:
    """Time the windows of scenes by both trees in turn; the first window of each is not warm."""
    with Tree(ROOT) as ours, Tree(other) as theirs:
        for plant in {scene.plant: scene for scene in scenes}.values():
            for tree in (ours, theirs):  # compiles
                tree.call(begin, plant)
                tree.call(step)
        return [_timed(scene, ours, theirs) for scene in progress(scenes, 'cost', len(scenes))]


def _timed(scene: Scene, ours: Tree, theirs: Tree) -> Timed:
    changes, windows = ours.call(begin, scene)
    theirs.call(begin, scene)
    seconds = np.empty((windows, 2))
    for k in range(windows):
        order = (0, 1) if k % 2 else (1, 0)
        for place in order:
            seconds[k, place] = (ours, theirs)[place].call(step)
    length = scene.length
    edges = length * np.arange(windows + 1.0)
    jumped = np.zeros(windows, dtype=np.bool_)
    for change in changes:
        jumped |= (edges[:-1] < change.time) & (change.time < edges[1:])
    return Timed(scene, seconds[1:, 0], seconds[1:, 1], jumped[1:])


def ratio(times: Sequence[Timed], jumped: bool) -> tuple[float, float, float]:
    """Return the median ratio of ours to theirs, with its interval over runs."""
    ratios = [(each.ours / each.theirs)[each.jumped == jumped] for each in times]
    ratios = [each for each in ratios if each.size]
    if not ratios:
        return np.nan, np.nan, np.nan
    return resampled(lambda places: float(np.median(stacked(ratios, places))), len(ratios))
