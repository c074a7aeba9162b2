"""Tables of published intervals: their coverage, the true profiles beside them, their cost."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

import numpy as np

from benchmarks.coverage.cost import Cell, Pair, ratio
from benchmarks.coverage.reference import Profile
from benchmarks.coverage.run import KINDS, WAYS, Track
from benchmarks.coverage.scores import (
    MISSED,
    Matched,
    Share,
    coverage,
    far,
    given_of_narrow,
    matched,
    median_width,
    single,
)
from benchmarks.report import Requirement, table
from benchmarks.zoo.experiments import EXPERIMENTS
from obs_ros.core.model import names

POOLED = (0.93, 0.97)  # of intervals of 95 %, all cells together
SINGLE = (0.92, 0.98)  # that each cell's interval meets
FAR_SHARE = 0.002  # of values, more than 5 deviations off
GIVEN = 0.95  # of parameters with a narrow true profile
WIDTHS = (0.9, 1.25)  # of published over true width, in the median
TIMES = {True: 1.05, False: 4.0}  # those of the other tree, rich and poor
WHAT = {False: 'parameters', True: 'end states'}

Item = TypeVar('Item')
Cells = Mapping[Cell, Sequence[Track]]
Profiles = Mapping[str, Sequence[Profile]]
Costs = Mapping[Cell, Sequence[Pair]]


def acceptance(cells: Cells, profiles: Profiles, costs: Costs) -> Iterator[Requirement]:
    """Yield what is asked of all cells, and of each."""
    for states, what in WHAT.items():
        pooled = coverage(all_of(cells.values()), states)
        yield Requirement(
            f'{what}: pooled coverage {POOLED[0]:g}-{POOLED[1]:g}',
            str(pooled),
            POOLED[0] <= pooled.value <= POOLED[1],
        )
        off = {label(cell): coverage(tracks, states) for cell, tracks in cells.items()}
        off = {cell: one for cell, one in off.items() if not one.meets(*SINGLE)}
        yield Requirement(
            f"{what}: each cell's interval meets {SINGLE[0]:g}-{SINGLE[1]:g}",
            '; '.join(f'{cell} {one}' for cell, one in off.items()) or f'all {len(cells)}',
            not off,
        )
        errors = far(all_of(cells.values()), states)
        yield Requirement(
            f'{what}: > 5 sd off in < {FAR_SHARE:.1%}', f'{errors.value:.2%}',
            errors.value < FAR_SHARE,
        )  # fmt: skip
    yield from _not_by_withholding(cells, profiles)
    for rich, kind in KINDS.items():
        chosen = all_of(pairs for cell, pairs in costs.items() if cell[1] == rich)
        if chosen:
            found = ratio(chosen)
            yield Requirement(
                f'{kind} windows: time <= {TIMES[rich]:g} x that of the other tree',
                '{:.2f} ({:.2f}-{:.2f})'.format(*found),
                found[0] <= TIMES[rich],
            )
    for sequence, way in WAYS.items():
        chosen = all_of(pairs for cell, pairs in costs.items() if cell[1:] == (True, sequence))
        if chosen:
            same = sum(pair.same for pair in chosen)
            asked = f'rich windows, {way}: values the same to the last bit'
            yield Requirement(asked, f'{same} of {len(chosen)}', same == len(chosen))


def _not_by_withholding(cells: Cells, profiles: Profiles) -> Iterator[Requirement]:
    pairs = all_of(pairs_of(cells, profiles, name) for name in profiles)
    if not pairs:
        return
    given = given_of_narrow(pairs)
    yield Requirement(
        f'poor, alone: of narrow true profiles >= {GIVEN:.0%} get a deviation',
        str(given),
        given.value >= GIVEN,
    )
    width = median_width(pairs)
    yield Requirement(
        f'poor, alone: published over true width {WIDTHS[0]:g}-{WIDTHS[1]:g} in the median',
        f'{width:.2f}',
        WIDTHS[0] <= width <= WIDTHS[1],
    )


def coverage_table(cells: Cells) -> str:
    """Tell coverage and errors of each cell, and of cells together."""
    rows = [row(label(cell), tracks) for cell, tracks in cells.items()]
    for rich, kind in KINDS.items():
        for sequence, way in WAYS.items():
            chosen = all_of(own for cell, own in cells.items() if cell[1:] == (rich, sequence))
            rows += [row(f'**all {kind}, {way}**', chosen)] if chosen else []
    return table([*rows, row('**all**', all_of(cells.values()))])


def row(name: str, tracks: Sequence[Track]) -> dict[str, object]:
    """Return the row of some runs."""
    found: dict[str, object] = {
        'cell': name,
        'windows': sum(len(track.outcomes) for track in tracks),
    }
    for states, what in WHAT.items():
        one = coverage(tracks, states)
        values = sum(track.error[:, track.part(states)].size for track in tracks)
        found[f'{what} given'] = f'{one.count}/{values}'
        found[f'coverage of {what}'] = one
        found[f'{what} > 5 sd'] = f'{far(tracks, states).value:.2%}'
    outcomes = Counter(outcome for track in tracks for outcome in track.outcomes)
    found['outcomes'] = ', '.join(f'{key} {count}' for key, count in outcomes.most_common())
    found['jumps'] = sum(sum(track.jumps) for track in tracks)
    return found


def parameters_table(cells: Cells) -> str:
    """Tell the coverage of each parameter by itself, of poor windows."""
    rows = []
    for cell, tracks in cells.items():
        if not cell[1]:
            each = (
                f'{name} {single(tracks, i).brief}'
                for i, name in enumerate(names(EXPERIMENTS[cell[0]].model.parameters))
            )
            rows.append({'cell': label(cell), 'coverage of those given': ', '.join(each)})
    return table(rows)


def reference_table(cells: Cells, profiles: Profiles) -> str:
    """Tell how the published intervals of poor windows, alone, lie beside the true profiles."""
    pairs = {name: pairs_of(cells, profiles, name) for name in profiles}
    rows = [reference_row(name, own) for name, own in pairs.items()]
    return table([*rows, reference_row('**all**', all_of(pairs.values()))])


def reference_row(name: str, pairs: Sequence[Matched]) -> dict[str, object]:
    """Return the row of some windows."""
    return {
        'plant': name,
        'windows': len(pairs),
        'true profiles hold the truth': Share.of([pair.true_held for pair in pairs]),
        f'excess > {MISSED:g}': sum(pair.excess > MISSED for pair in pairs),
        'end on both sides': Share.of([pair.bounded for pair in pairs]).brief,
        'narrow ones given': given_of_narrow(pairs),
        'coverage, given but not narrow': Share.of(
            [pair.held[pair.given & ~pair.narrow] for pair in pairs]
        ).brief,
        'published over true width': f'{median_width(pairs):.2f}',
        'coverage, narrow and given': Share.of([pair.held[pair.both_given] for pair in pairs]),
        'where the optimum is found': Share.of(
            [pair.held[pair.both_given] for pair in pairs if pair.excess <= MISSED]
        ),
        'of their true profiles': Share.of([pair.true_held[pair.both_given] for pair in pairs]),
    }


def cost_table(costs: Costs) -> str:
    """Tell process times beside those of the other tree."""
    rows = []
    for cell, pairs in costs.items():
        median, low, high = ratio(pairs)
        rows.append({
            'cell': label(cell),
            'windows': len(pairs),
            'ms': f'{1e3 * np.median([pair.own.seconds for pair in pairs]):.1f}',
            'other, ms': f'{1e3 * np.median([pair.other.seconds for pair in pairs]):.1f}',
            'median of ratios': f'{median:.2f} ({low:.2f}-{high:.2f})',
            'largest': f'{max(pair.ratio for pair in pairs):.1f}',
            'same bits': f'{sum(pair.same for pair in pairs)}/{len(pairs)}',
        })  # fmt: skip
    return table(rows) if rows else 'Not measured: `--against` names another tree.'


def label(cell: Cell) -> str:
    """Return the name of a cell."""
    name, rich, sequence = cell
    return f'{name}, {KINDS[rich]}, {WAYS[sequence]}'


def all_of(groups: Iterable[Sequence[Item]]) -> list[Item]:
    """Return the items of all groups, in order."""
    return [item for group in groups for item in group]


def pairs_of(cells: Cells, profiles: Profiles, name: str) -> list[Matched]:
    """Return the poor windows of a plant, alone, beside their true profiles."""
    model = EXPERIMENTS[name].model
    return [
        matched(model, track, profile)
        for track, profile in zip(cells[name, False, False], profiles[name], strict=False)
    ]
