"""Tests of obs_ros.optimization.acceptance."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from obs_ros.optimization.acceptance import (
    Acceptance,
    acceptance_with_noise,
    acceptance_without_noise,
)


@pytest.mark.parametrize(
    ('squares', 'converged', 'rounds', 'rule'),
    [
        (100.0, True, 1, Acceptance.LIKE_NOISE),
        (100.0, False, 1, None),  # it may still fall to what noise hardly leaves
        (200.0, True, 1, None),
        (200.0, True, 2, Acceptance.ROUNDS),
        (200.0, False, 2, Acceptance.ROUNDS),
    ],
)
def test_beside_known_noise(
    squares: float, converged: bool, rounds: int, rule: Acceptance | None
) -> None:
    assert acceptance_with_noise(squares, 100, converged=converged, rounds=rounds) is rule


def problem(*, white: bool) -> Any:
    noise = np.random.default_rng(0).standard_normal((400, 1))
    residuals = noise if white else np.cumsum(noise, axis=0)
    return SimpleNamespace(
        signal=4.0, nodes=400, count=lambda nodes: nodes, residuals=lambda z: residuals
    )


@pytest.mark.parametrize(
    ('white', 'rounds', 'flat', 'survivors', 'rule'),
    [
        (True, 1, 1, 1, None),
        (True, 1, 1, 2, Acceptance.WHITE_SURVIVORS),
        (True, 2, 2, 0, Acceptance.WHITE_ROUNDS),
        (True, 1, 2, 0, None),  # another optimum, nearly as low
        (False, 1, 1, 5, None),
        (False, 2, 2, 0, Acceptance.ROUNDS),
        (False, 1, 2, 0, Acceptance.ROUNDS),  # a flat valley: of no candidate is this noise
    ],
)
def test_without_noise_whiteness_stands_in_for_size(
    white: bool, rounds: int, flat: int, survivors: int, rule: Acceptance | None
) -> None:
    found = acceptance_without_noise(
        problem(white=white), np.zeros(2), 300.0,
        rounds=rounds, flat=flat, survivors=survivors, negligible=1e-6,
    )  # fmt: skip
    assert found is rule


def test_rounding_need_not_be_white() -> None:
    found = acceptance_without_noise(
        problem(white=False), np.zeros(2), 1e-9, rounds=1, flat=1, survivors=2, negligible=1e-6
    )
    assert found is Acceptance.WHITE_SURVIVORS
