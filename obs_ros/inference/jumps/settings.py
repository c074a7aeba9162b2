"""Prior odds of jumps, and the margins, steps and budgets of the search for them."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class JumpSettings:
    """Numbers that decide about jumps; gains are in units of -2 log evidence.

    Prior odds enter as penalties, -2 log of a probability. Screening is linear, so that a move a
    little short of a gain is solved exactly all the same. The margins and budgets below were
    chosen on the sequences of benchmarks/results/sequence.md and on the faults of
    benchmarks/results/interconnected.md; the cost of windows that nothing explains is bounded by
    test/horizon/test_cost.py.
    """

    # Prior odds.
    prior_probability: float = 0.01  # that a parameter jumps, in one window length
    further_probability: float = 0.1  # that another one jumps at the same time
    most_jumps: int = 4  # of single parameters in a window: more look like a drift
    # Screening.
    times: int = (
        8  # parts of the window at whose ends a jump is sought, and then finer parts of one
    )
    hopeful: float = -2.0  # gain of a move, to first order, above which it is solved exactly
    hopeful_after_known: float = -6.0  # the same, where a jump is known: its linearisation is worse
    rivals: int = 3  # moves solved exactly in one round
    rival_margin: float = 12.0  # gain by which a rival may lag the best: 400 times less likely
    similar: float = 6.0  # that alternatives may lack: the best is at most 20 times as likely
    # Budgets.
    iterations: int = 40  # rollouts of one exact solution
    latest: int = 6  # rollouts from whose gain that of all to come is foretold
    out_of_reach: float = 60.0  # cost: more than the logarithms of determinants make up for
    hardly: float = 0.01  # share of the squares, gained less by which a misfit is given up
    rollouts_per_unknown: int = (
        28  # for an unexplained window: keeps it within 8 times a fitting one
    )
    # Differences.
    probe_step: float = 1e-7  # box, where a derivative is all that is wanted
    step: float = 0.3  # standard deviations of the noise by which a step moves the outputs
    step_ratio: float = 4.0  # between the step taken and the one wanted
    step_trials: int = 4  # linearisations until the step fits
    first_step: float = 1e-5  # box
    smallest_step: float = 1e-11  # box
    largest_step: float = 1e-3  # box: a chaotic plant is linear no further

    @property
    def jump_penalty(self) -> float:
        """-2 log of the probability that one parameter jumps in a window."""
        return 2.0 * math.log(1.0 / self.prior_probability)

    @property
    def further_penalty(self) -> float:
        """-2 log of the probability that another one jumps at the same time."""
        return 2.0 * math.log(1.0 / self.further_probability)

    def earlier_penalty(self, gap: float) -> float:
        """-2 log of the probability of a jump in the `gap` (windows) before; inf for no gap."""
        return max(0.0, self.jump_penalty - 2.0 * math.log(gap)) if gap > 0.0 else math.inf


JUMP_SETTINGS = JumpSettings()
