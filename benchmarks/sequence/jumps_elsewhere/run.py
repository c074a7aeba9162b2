"""The runs that are solved, by this source tree and by another one."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from benchmarks.runner import monte_carlo
from benchmarks.sequence.jumps_elsewhere.cost import Timed, compare
from benchmarks.sequence.jumps_elsewhere.follow import Followed, followed
from benchmarks.sequence.jumps_elsewhere.scenes import CLEAN, JUMP, KINDS, PLANTS, Scene
from benchmarks.trees import Tree, called_in

RUNS, WINDOWS = 40, 20
TIMED = 6  # runs of each plant, at most
EXCITATIONS = {True: 'rich', False: 'poor'}


class Cell(NamedTuple):
    """A plant, what happens, and how it is excited."""

    plant: str
    kind: str
    rich: bool


Cells = Mapping[Cell, Sequence[Followed]]


class Measured(NamedTuple):
    """Everything measured; `theirs` and `times` only where another tree was given."""

    cells: Cells
    theirs: Cells
    times: Sequence[Timed]


def plan(runs: int, windows: int, seed: int) -> dict[Cell, list[Scene]]:
    """Return the scenes: so many clean runs in each cell, and twice as many with jumps.

    Few jumps are misnamed. Runs of other kinds are as many for each plant, half of them poor.
    """
    found = {}
    for plant in PLANTS:
        for kind in KINDS:
            for rich in EXCITATIONS:
                count = {CLEAN: runs, JUMP: 2 * runs}.get(kind, (runs + rich) // 2)
                found[Cell(plant, kind, rich)] = [
                    Scene(plant, kind, rich, each, windows) for each in range(seed, seed + count)
                ]
    return found


def carried_out(chosen: Mapping[Cell, Sequence[Scene]], other: Path | None) -> Measured:
    """Do it all on all cores; what another tree is compared in, by that, too."""
    compile_all(chosen)
    cells = solved_by(chosen, 'jumps elsewhere')
    if other is None:
        return Measured(cells, {}, ())
    shared = {cell: scenes for cell, scenes in chosen.items() if cell.kind in (CLEAN, JUMP)}
    with Tree(other) as tree:
        tree.call(compile_all, shared)
    theirs = solved_by(shared, 'by the other tree', other)
    timed = [
        scene
        for cell, scenes in shared.items()
        if cell.kind == JUMP
        for scene in scenes[: TIMED // len(EXCITATIONS)]
    ]
    return Measured(cells, theirs, compare(timed, other))


def solved_by(
    chosen: Mapping[Cell, Sequence[Scene]], label: str, other: Path | None = None
) -> dict[Cell, list[Followed]]:
    """Solve the scenes by the package of this source tree, or of another one."""
    work, before = (followed, ()) if other is None else (called_in, (other, followed))
    runs = {cell: [(*before, scene) for scene in scenes] for cell, scenes in chosen.items()}
    return monte_carlo(work, runs, label)


def compile_all(chosen: Mapping[Cell, Sequence[Scene]]) -> None:
    """Compile here, once, so that the workers find the kernels cached."""
    for plant in {cell.plant for cell in chosen}:
        followed(Scene(plant, JUMP, True, 1, 6))
