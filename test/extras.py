"""Packages that `make test` does without."""

import importlib.util
import os

import pytest


def needs(package: str, target: str) -> None:
    """Skip the test where a package is not installed; fail it where `make TARGET` runs it."""
    if importlib.util.find_spec(package) is None:
        assert os.environ.get('OBS_ROS_TEST_EXTRA') != target, f'{package} should be installed'
        pytest.skip(f'{package} is not installed: make {target}')
