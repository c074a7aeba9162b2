"""Tests of obs_ros.integration.kernel_modules: generated modules and their cache."""

import logging
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from plants import BLOW_UP, OSCILLATOR

pytest.importorskip('numba')

from obs_ros.integration.compiled import CompiledStepper
from obs_ros.integration.kernel_modules import code_of, load_filter, load_module
from obs_ros.integration.stepper import run_once


def test_equal_models_share_a_module_and_others_do_not() -> None:
    assert load_module(OSCILLATOR) is load_module(replace(OSCILLATOR, name='x', max_step=0.3))
    assert load_module(OSCILLATOR) is not load_module(replace(OSCILLATOR, integrator='euler'))


def test_a_filter_shares_what_is_the_same_in_the_rollouts() -> None:
    base, filters = (vars(each) for each in (load_module(OSCILLATOR), load_filter(OSCILLATOR, 4)))
    assert filters['dynamics'] is base['dynamics'] and filters['advance'] is base['advance']
    for name in base.keys() & filters.keys():
        known, own = base[name], filters[name]
        if hasattr(own, 'py_func') and own is known:
            assert code_of(own.py_func) == code_of(known.py_func)
    assert filters['squares'] is not base['squares']


def test_functions_are_the_same_by_what_they_do() -> None:
    first, second, third = (lambda x: x + 1.0), (lambda x: x + 1.0), (lambda x: x + 2.0)
    assert code_of(first) == code_of(second) != code_of(third)


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
        logger = 'obs_ros.integration.kernel_modules'
        assert caplog.record_tuples == [(logger, logging.INFO, announcement)] * announced
        sys.modules.pop(load_module(stepper.model).__name__)
