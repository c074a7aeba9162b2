"""Tests of obs_ros.models.observer_form_third_order, against Gremling & Passino 2000."""

import numpy as np
import pytest

from obs_ros import Model
from obs_ros.core.model import inside
from obs_ros.models.observer_form_third_order import (
    OBSERVER_FORM_THIRD_ORDER,
    OBSERVER_FORM_THIRD_ORDER_NMP,
)

BOTH = (OBSERVER_FORM_THIRD_ORDER, OBSERVER_FORM_THIRD_ORDER_NMP)


def matrices(model: Model) -> tuple[np.ndarray, np.ndarray]:
    p = tuple(inside(v) for v in model.parameters)
    A = np.array([model.dynamics(0.0, tuple(e), (0.0,), p) for e in np.eye(3)]).T
    return A, np.array(model.dynamics(0.0, (0.0, 0.0, 0.0), (1.0,), p))


def test_the_matrices_of_eq_20() -> None:
    A, b = matrices(OBSERVER_FORM_THIRD_ORDER_NMP)
    assert A.tolist() == [[-2.9, 1.0, 0.0], [-2.91, 0.0, 1.0], [-0.959, 0.0, 0.0]]
    assert b.tolist() == [0.0, 1.0, -0.05]


@pytest.mark.parametrize(
    ('model', 'poles', 'zeros'),
    [
        # (s + 1)(s^2 + 1.1 s + 1) and s^2 + 0.9 s + 0.8.
        (BOTH[0], [-1.0, -0.55 - 0.8351647j, -0.55 + 0.8351647j],
         [-0.45 - 0.7729812j, -0.45 + 0.7729812j]),
        (BOTH[1], [-1.1 - 0.4j, -1.1 + 0.4j, -0.7], [0.05]),
    ],
)  # fmt: skip
def test_poles_and_zeros_of_the_paper(
    model: Model, poles: list[complex], zeros: list[complex]
) -> None:
    A, b = matrices(model)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(A)), poles, atol=1e-6)
    # The observer form's numerator is b itself.
    np.testing.assert_allclose(np.sort_complex(np.roots(b)), zeros, atol=1e-6)
    assert model.output(0.0, (1.0, 2.0, 3.0), (4.0,), ()) == (1.0,)


def test_the_two_differ_in_what_is_known_beforehand_only() -> None:
    assert BOTH[0].dynamics is BOTH[1].dynamics and BOTH[0].output is BOTH[1].output
    lower, upper = np.array([[(v.lower, v.upper) for v in m.parameters] for m in BOTH]).T
    assert lower.T.tolist() == [[1.8, 1.8, 0.8, 0.8, 0.7, 0.6], [2.7, 2.7, 0.8, -0.2, 0.7, -0.2]]
    assert upper.T.tolist() == [[2.3, 2.3, 1.2, 1.2, 1.1, 1.1], [3.2, 3.2, 1.2, 0.2, 1.2, 0.2]]
