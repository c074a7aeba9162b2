"""Process time of clean windows: by other settings, and by another source tree."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.runner import ROOT, progress
from benchmarks.sensors.attempts import attempted
from benchmarks.sensors.spring import NOISE, run
from benchmarks.sensors.timed import least_seconds
from benchmarks.trees import Tree
from obs_ros import Record

NOISES = {'y': NOISE}


def paired(options: Mapping[str, Any], others: Mapping[str, Any], seed: int) -> tuple[float, float]:
    """Return the process times (s) of a clean window with either options, in turns."""
    record = run(seed).record
    for each in (options, others):
        least_seconds(record, seed, {'noise': NOISES, **each})  # warm
    pair = [least_seconds(record, seed, {'noise': NOISES, **each}) for each in (options, others)]
    return pair[0], pair[1]


def against(other: Path, seeds: Sequence[int]) -> list[Any]:
    """Return the process times (s) of clean windows by this tree and by another, in turns."""

    def pairs() -> list[tuple[float, float]]:
        with Tree(ROOT) as own, Tree(other) as theirs:

            def seconds(tree: Tree, record: Record, seed: int) -> float:
                return float(tree.call(least_seconds, record, seed, {'noise': NOISES}))

            for tree in (own, theirs):
                seconds(tree, run(seeds[0]).record, seeds[0])  # compiles
            records = {seed: run(seed).record for seed in seeds}
            return [
                (seconds(own, records[seed], seed), seconds(theirs, records[seed], seed))
                for seed in progress(seeds, 'clean windows', len(seeds))
            ]

    found = attempted(pairs)
    return found if isinstance(found, list) else [found]
