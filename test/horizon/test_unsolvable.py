"""Windows that cannot be solved say so, with what they need."""

import numpy as np
import pytest
from plants import INTEGRATOR, tank_record

from obs_ros import Outcome, Record, solve_window
from obs_ros.core.deadline import Deadline
from obs_ros.core.rng import random_generator
from obs_ros.horizon.moving_horizon import MovingHorizon
from obs_ros.horizon.settings import POSING
from obs_ros.horizon.solver import Solver
from obs_ros.horizon.unsolvable import TooManySteps, check_steps
from obs_ros.models.three_tank import THREE_TANK


def in_nanoseconds() -> Record:
    """A window of three tanks whose times are in ns in place of s."""
    record = tank_record(nodes=51)
    return Record(1e9 * record.t, record.u, record.y)


def test_times_in_another_unit_end_at_once_with_the_remedy() -> None:
    estimate = solve_window('three_tank', in_nanoseconds(), backend='numpy')
    assert estimate.outcome is Outcome.DIVERGED and not estimate.usable
    assert estimate.message.startswith('give times in s, or a max_step longer than 1 s')
    found = MovingHorizon(Solver.of(THREE_TANK)).solve(
        in_nanoseconds(), random_generator(0), Deadline()
    )
    assert (found.outcome, found.message) == (estimate.outcome, estimate.message)


def test_the_limit_is_that_of_the_settings_and_none_without_a_step() -> None:
    length = 1.01 * POSING.most_steps * THREE_TANK.max_step
    record = Record([0.0, length], np.full((2, 2), 30.0), np.zeros((2, 2)))
    with pytest.raises(TooManySteps, match=f'more than {POSING.most_steps} steps'):
        check_steps(THREE_TANK, record)
    check_steps(THREE_TANK, Record(0.98 * record.t, record.u, record.y))
    check_steps(INTEGRATOR, Record(record.t, record.u[:, :1], record.y[:, :1]))
