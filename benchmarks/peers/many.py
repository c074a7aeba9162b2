"""What is asked of windows with many unknowns, beside scipy's least squares and CasADi."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.peers.registry import OURS
from benchmarks.peers.report import by_case, by_peer, time_ratio
from benchmarks.peers.run import Measured
from benchmarks.report import Requirement

# The oracle stops scipy's descents, which have their Jacobians in one of our rollouts: it is the
# fastest way to use scipy that does not depend on luck.
SCIPY, CASADI = 'scipy least_squares, restarts', 'CasADi multiple shooting'
RATIOS = {SCIPY: 5.0, CASADI: 50.0}  # times our time, at least
PEERS = (
    OURS, 'scipy least_squares, 1 start', 'scipy least_squares, 1 start, batched', SCIPY, CASADI,
)  # fmt: skip
MOST = 1.3e8  # candidate-steps of the C twin that a window of most unknowns may take


def acceptance(results: Sequence[Measured], c_step: float) -> Iterator[Requirement]:
    """Yield what is asked of every case; a candidate-step takes `c_step` s in C."""
    cases = by_case(results)
    for case, own in cases.items():
        peers = by_peer(own)
        for name, least in RATIOS.items():
            if name in peers:
                yield _slower(f'{case}: {name} >= {least:g} x our time', peers[name], least)
        ours = peers[OURS]
        solved = sum(one.reached for one in ours)
        told = f'{solved} of {len(ours)}'
        yield Requirement(f'{case}: all solved', told, solved == len(ours))
        if case.endswith(' 60 unknowns'):
            steps = float(np.median([one.seconds for one in ours])) / c_step
            asked = f'{case}: <= {MOST:.2g} candidate-steps in C'
            yield Requirement(asked, f'{steps:.2g}', steps <= MOST)


def _slower(asked: str, results: Sequence[Measured], least: float) -> Requirement:
    """Judge the median ratio of a peer's time to ours."""
    ratios = [one.seconds / one.ours for one in results]
    reached = sum(one.reached for one in results)
    told = (
        f'{time_ratio(results):.3g} ({min(ratios):.3g} to {max(ratios):.3g}), '
        f'{reached} of {len(results)} solved'
    )
    return Requirement(asked, told, time_ratio(results) >= least)
