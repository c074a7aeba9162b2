"""Tables and verdicts of the peers."""

from collections.abc import Sequence

import numpy as np

from benchmarks.judge import SAME_OPTIMUM
from benchmarks.peers.problem import case_of
from benchmarks.peers.registry import OURS, PEERS
from benchmarks.peers.run import Measured
from benchmarks.report import table


def report(results: Sequence[Measured], missing: Sequence[str]) -> dict[str, str]:
    """Return the tables and verdicts of all cases, and the names of peers that are missing."""
    cases = (
        f'## {case}\n\n{case_table(own)}\n\n{verdict(own)}'
        for case, own in by_case(results).items()
    )
    absent = f'Not installed, so skipped: {", ".join(missing)}.' if missing else ''
    return {'cases': '\n\n'.join(cases), 'missing': absent}


def by_case(results: Sequence[Measured]) -> dict[str, list[Measured]]:
    """Return the results of every case."""
    cases = dict.fromkeys(one.case for one in results)
    return {case: [one for one in results if one.case == case] for case in cases}


def by_peer(results: Sequence[Measured]) -> dict[str, list[Measured]]:
    """Return the results of every peer, in the order of the registry."""
    return {name: own for name in PEERS if (own := [one for one in results if one.peer == name])}


def case_table(results: Sequence[Measured]) -> str:
    """Return the table of one case: every peer's medians, against ours on the same windows."""
    peers = by_peer(results)
    return table(row(own, peers[OURS]) for own in peers.values())


def row(results: Sequence[Measured], ours: Sequence[Measured]) -> dict[str, object]:
    """Return one line: a peer's medians over its windows, against ours on the same ones."""
    peer = PEERS[results[0].peer]
    same = [one for one in ours if one.seed in {other.seed for other in results}]
    solved = [one for one in results if one.reached]
    bound = '> ' if 2 * len(solved) < len(results) and not peer.filters else ''
    error, own = (
        [median(one, name) for name in ('parameter_error', 'state_error')]
        for one in (results, same)
    )
    time, where_solved = bound + f'{time_ratio(results):.3g}', '-'
    if peer.name == OURS:
        time = where_solved = '1'
    elif solved:
        where_solved = f'{time_ratio(solved):.3g}'
    return {
        'peer': peer.name,
        'solved': '-' if peer.filters else f'{len(solved)}/{len(results)}',
        'median (ms)': bound + f'{1e3 * median(results, "seconds"):.3g}',
        'time / ours': time,
        'time / ours where solved': where_solved,
        'build (s)': f'{median(results, "build"):.2g}',
        'excess (sigma^2)': '-' if peer.filters else f'{median(results, "excess"):.2g}',
        'parameter error / ours': f'{error[0] / own[0]:.2g}',
        'end state error / ours': f'{error[1] / own[1]:.2g}',
    }


def median(results: Sequence[Measured], name: str) -> float:
    """Return the median of one figure."""
    return float(np.median([getattr(one, name) for one in results]))


def time_ratio(results: Sequence[Measured]) -> float:
    """Return the median ratio of a peer's time to ours on the same window."""
    return float(np.median([one.seconds / one.ours for one in results]))


def verdict(results: Sequence[Measured]) -> str:
    """Say whether ours is the fastest to the target, and who wins if not."""
    peers = by_peer(results)
    ours = peers.pop(OURS)
    share = solved_share(ours)
    lines, close = [], []
    for name, own in peers.items():
        if PEERS[name].filters or name.startswith(OURS):
            continue
        ratio, reached = time_ratio(own), [one for one in own if one.reached]
        if solved_share(own) >= share and ratio < 1.0:
            lines.append(f'**{name} wins**: it takes {ratio:.2f} times our time.')
        elif reached and time_ratio(reached) < 1.0:
            lines.append(
                f'{name} is quicker ({time_ratio(reached):.2f} times our time) where it succeeds, '
                f'which it does on {len(reached)} of {len(own)} windows.'
            )
        elif solved_share(own) >= share:
            quicker = sum(one.seconds < one.ours for one in own)
            close.append((ratio, name, f'quicker than ours on {quicker} of {len(own)}'))
    if not lines:
        lines.append('By the median, ours is faster than every peer to the same accuracy.')
    if close:
        ratio, name, quicker = min(close)
        lines.append(f'The closest that solves as many is {name}: {ratio:.3g} x, {quicker}.')
    missed = SAME_OPTIMUM * len(case_of(results[0].case).model.variables)
    better = sum(one.excess < -missed for one in results)
    lines.append(
        f'Ours solves {sum(one.reached for one in ours)} of {len(ours)}; points better than the '
        f"judge's by the target's width: {better}."
    )
    return ' '.join(lines)


def solved_share(results: Sequence[Measured]) -> float:
    """Return the share of windows solved."""
    return float(np.mean([one.reached for one in results]))
