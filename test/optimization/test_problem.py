"""Tests of obs_ros.optimization.problem."""

import pytest

from obs_ros.inference.jumps.piecewise import PiecewiseProblem
from obs_ros.inference.objective import Objective
from obs_ros.inference.prior import Posterior
from obs_ros.optimization.problem import Linearised, Problem


@pytest.mark.parametrize(
    ('protocol', 'kind'),
    [(Problem, Objective), (Problem, Posterior), (Linearised, PiecewiseProblem)],
)
def test_what_is_minimised_offers_all_that_methods_may_ask(protocol: type, kind: type) -> None:
    asked = {
        name for base in protocol.__mro__ for name in vars(base)
        if not name.startswith('_') and base is not object
    }  # fmt: skip
    assert {'limits', 'linearise'} <= asked
    assert [name for name in sorted(asked) if not hasattr(kind, name)] == []
