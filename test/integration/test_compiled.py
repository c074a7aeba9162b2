"""Tests of obs_ros.integration.compiled: generated modules and their cache."""

import logging
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plants import BLOW_UP, OSCILLATOR

pytest.importorskip('numba')

from obs_ros.integration.backends import run_once as run_kernels_once
from obs_ros.integration.backends import run_process_noise_once
from obs_ros.integration.compiled import (
    CompiledKernels,
    CompiledStepper,
    load_module,
    padded,
)
from obs_ros.integration.stepper import run_once


def test_equal_models_share_a_module_and_others_do_not() -> None:
    assert load_module(OSCILLATOR) is load_module(replace(OSCILLATOR, name='x', max_step=0.3))
    assert load_module(OSCILLATOR) is not load_module(replace(OSCILLATOR, integrator='euler'))


def test_what_process_noise_needs_does_not_compile_before_it_is_used() -> None:
    model = replace(BLOW_UP, dynamics=lambda t, x, u, p: (0.1 * x[0],))
    kernels = CompiledKernels(model)
    run_kernels_once(kernels)
    module = load_module(model)
    assert module.squares.signatures and module.grams.signatures
    injected = (module.squares_injected, module.grams_injected, module.trajectories_injected)
    assert not any(kernel.signatures for kernel in injected)
    run_process_noise_once(kernels)
    assert all(kernel.signatures for kernel in injected)


def own(gain: float) -> Any:
    return replace(BLOW_UP, dynamics=lambda t, x, u, p: (gain * x[0],))


def test_compiling_is_announced_once_and_loading_is_not(
    tmp_path: Path, monkeypatch: Any, caplog: Any
) -> None:
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    announcement = "compiling the kernels of model 'blow_up': several seconds, once"
    for announced in (1, 0):
        caplog.clear()
        with caplog.at_level(logging.INFO, 'obs_ros'):
            stepper = CompiledStepper(own(-3.0))
            run_once(stepper)
        logger = 'obs_ros.integration.compiled'
        assert caplog.record_tuples == [(logger, logging.INFO, announcement)] * announced
        sys.modules.pop(load_module(stepper.model).__name__)


@pytest.mark.parametrize(('count', 'lanes'), [(1, 16), (16, 16), (17, 32), (31, 32)])
def test_lanes_are_filled_with_the_last_candidate(count: int, lanes: int) -> None:
    x, p = padded(np.arange(2.0 * count).reshape(2, count), np.empty((0, count)))
    assert (x.shape, p.shape) == ((2, lanes), (0, lanes))
    assert x.flags.c_contiguous
    assert (x[:, count:] == x[:, count - 1 : count]).all()
