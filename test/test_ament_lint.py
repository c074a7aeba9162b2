"""The lint of ROS, where it is installed: `colcon test` runs it, the wheels have none."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_ament_flake8_finds_nothing():
    flake8 = pytest.importorskip('ament_flake8.main')
    folders = [str(ROOT / package) for package in ('obs_ros', 'plant_sim')]
    config = str(ROOT / 'test' / 'flake8.ini')
    code, errors = flake8.main_with_errors(argv=['--config', config, *folders])
    assert code == 0, '\n'.join(errors)
