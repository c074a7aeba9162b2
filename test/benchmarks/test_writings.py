"""One plant, written in many ways: the same results, by as many operations."""

import dis
from typing import Any

import numpy as np
import pytest

from benchmarks.writings.models import WRITINGS, pendulums, scalars
from benchmarks.writings.run import rollout

MARGIN = 1.3  # times the operations of the function in scalars
WORK = ('BINARY_OP', 'COMPARE_OP', 'UNARY_NEGATIVE', 'CALL')


def operations(function: Any) -> int:
    return sum(step.opname in WORK for step in dis.get_instructions(function))


@pytest.mark.parametrize('writing', WRITINGS)
def test_each_way_of_writing_comes_to_the_same_operations(writing: str) -> None:
    model = pendulums(WRITINGS[writing])
    found = rollout(model, 'numpy', 20)()
    np.testing.assert_allclose(found, rollout(pendulums(scalars), 'numpy', 20)(), rtol=1e-12)
    assert operations(model.dynamics) <= MARGIN * operations(scalars)


def test_ways_of_writing_run_compiled() -> None:
    pytest.importorskip('numba')
    wanted = rollout(pendulums(scalars), 'numpy', 20)()
    for writing in ('A @ x, parameters', 'if and else'):
        model = pendulums(WRITINGS[writing])
        np.testing.assert_allclose(rollout(model, 'numba', 20)(), wanted, rtol=1e-9)
