"""Tests of obs_ros.integration.compiled: compiled rollouts."""

import sys

import numpy as np
import pytest
from kalman_reference import CART

pytest.importorskip('numba')

from obs_ros.integration.backends import correction_rehearsed, rollouts_rehearsed
from obs_ros.integration.backends import run_once as run_kernels_once
from obs_ros.integration.compiled import (
    CompiledKernels,
    padded,
)
from obs_ros.integration.kernel_modules import load_module

KERNELS = {
    kind + corrected
    for kind in ('squares', 'grams', 'trajectories')
    for corrected in ('', '_injected')
}


def test_kernels_compile_one_after_the_other_when_they_are_first_used(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, load_module(CART).__name__)  # of a new one nothing was used
    kernels, module = CompiledKernels(CART), load_module(CART)

    def compiled() -> set[str]:
        return {name for name, each in vars(module).items()
                if name in KERNELS and each.signatures}  # fmt: skip

    assert compiled() == set()
    run_kernels_once(kernels)
    assert compiled() == {'trajectories'}
    steps, moving = [], np.array([1])
    for rehearsed in (rollouts_rehearsed(kernels), correction_rehearsed(kernels, moving)):
        for _ in rehearsed:
            steps.append(compiled())
    assert [len(each) for each in steps] == [1, 2, 3, 3, 3, 3, 3, 4, 5, 6]
    assert steps[-1] == KERNELS


@pytest.mark.parametrize(('count', 'lanes'), [(1, 16), (16, 16), (17, 32), (31, 32)])
def test_lanes_are_filled_with_the_last_candidate(count: int, lanes: int) -> None:
    x, p = padded(np.arange(2.0 * count).reshape(2, count), np.empty((0, count)))
    assert (x.shape, p.shape) == ((2, lanes), (0, lanes))
    assert x.flags.c_contiguous
    assert (x[:, count:] == x[:, count - 1 : count]).all()
