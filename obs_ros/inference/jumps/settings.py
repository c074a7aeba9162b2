"""Prior odds of jumps, and the margins, steps and budgets of the search for them."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class JumpSettings:
    """Prior odds, margins, budgets and difference steps; gains are in units of -2 log evidence.

    The odds and margins are those of the tables of sequences, benchmarks/results/sequence.md: jumps
    found in the first window that shows them, without false alarms. The budgets keep windows that
    nothing explains within 8 times the cost of those that fit, test/horizon/test_cost.py.
    """

    # Prior odds.
    prior_probability: float = 0.01  # that a parameter jumps in a window's length; its walk, too
    further_probability: float = 0.1  # that another one jumps at the same time
    most_jumps: int = 4  # of single parameters in one window: more would be a drift
    # Margins.
    times: int = 8  # parts of the window, in two of which starts of one jump are sought
    times_rolled: int = 32  # parts between which jumps are screened where each is rolled out
    earliest: float = 0.0625  # share of the window: a jump before it is one before the window
    least_share: float = 1e-3  # of a jump's squares, that nothing else explains: below, errors of
    # the two sets of differences in the squares, 1e-4 of them, are as large
    times_nearby: int = 17  # tried within a quarter of such a part, beside process noise
    rivals: int = 3  # moves solved exactly in one round
    rival_margin: float = 12.0  # by which their scores may lag the best: 400 times less likely
    least_weight: float = 0.05  # probability below which a hypothesis counts for nothing: what a
    # 95 % interval leaves out, as it would reach to where hardly anything lies
    # Budgets.
    iterations: int = 40  # rollouts of one exact solution
    trail: int = 6  # latest rollouts, whose mean gain foretells that of those to come
    out_of_reach: float = 60.0  # cost above the least: more than determinants can make up for
    least_gain: float = 0.01  # share of the squares, in the latest rollouts of a window unexplained
    rollouts_per_unknown: int = 16  # of a window unexplained, again for each halving of its squares
    # Difference steps.
    probe_step: float = 1e-7  # box, where the derivative is all that is wanted
    noise_step: float = 0.3  # standard deviations of the noise by which a step moves the outputs
    step_ratio: float = 4.0  # between the step taken and that wanted
    step_trials: int = 4  # linearisations until the step suits
    first_step: float = 1e-5  # box
    smallest_step: float = 1e-11  # box
    largest_step: float = 1e-3  # box: an unknown that moves nothing

    @property
    def jump_penalty(self) -> float:
        """-2 log of the probability that one parameter jumps in a window."""
        return 2.0 * math.log(1.0 / self.prior_probability)

    @property
    def reach(self) -> float:
        """-2 log of the odds at which a hypothesis counts for nothing beside another."""
        return 2.0 * math.log(1.0 / self.least_weight)

    @property
    def further_penalty(self) -> float:
        """-2 log of the probability that another one jumps at the same time."""
        return 2.0 * math.log(1.0 / self.further_probability)

    def unseen(self, gap: float, visible: float) -> float:
        """Return the time (windows) before a window in which a jump would have gone unseen.

        That is the `gap` since the last one known, and the share of that one which saves less
        squares than a jump costs; a whole window saves `visible` ones.
        """
        return gap + self.jump_penalty / max(visible, self.jump_penalty)

    def earlier_penalty(self, unseen: float) -> float:
        """-2 log of the probability of a jump in the `unseen` time (windows) before a window."""
        return max(0.0, self.jump_penalty - 2.0 * math.log(unseen))


JUMP_SETTINGS = JumpSettings()
