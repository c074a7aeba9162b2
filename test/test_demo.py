"""`make demo` as a user runs it, only faster."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from patience import patience

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent


def test_demo_finds_every_valve_and_draws_a_picture(tmp_path: Path) -> None:
    packages = pytest.importorskip('ament_index_python.packages')
    pytest.importorskip('matplotlib')
    try:
        packages.get_package_prefix('obs_ros')
    except packages.PackageNotFoundError:
        pytest.skip('obs_ros is not installed in a prefix of AMENT_PREFIX_PATH')
    picture = tmp_path / 'demo.png'
    run = subprocess.run(
        [sys.executable, '-m', 'demo.three_tank', '--speed', '400', '--picture', str(picture)],
        cwd=ROOT,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        text=True,
        timeout=patience(60.0),
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert 'more than' not in run.stdout
    jumps = run.stdout.split('found to have jumped')[1]
    assert jumps.count(' by ') == 4
    assert picture.read_bytes()[:4] == b'\x89PNG'
