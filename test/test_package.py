import ast
import os
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from ament_index_python.packages import get_package_prefix
from catkin_pkg.package import parse_package

ROOT = Path(__file__).resolve().parents[1]
EXECUTABLES = ('check_model', 'estimator', 'fleet', 'init', 'replay', 'simulator', 'view')
ROS_SIDE = ('obs_ros.ros', 'plant_sim.node')
# Text that generated modules are made of: read, never imported.
TEMPLATES = {
    f'obs_ros.integration.{file.stem}'
    for file in (Path(__file__).parents[1] / 'obs_ros' / 'integration').glob('kernels*.py')
}

MANIFEST = parse_package(ROOT / 'package.xml')
DECLARED = {dependency.name for dependency in MANIFEST.exec_depends}
ROS_PACKAGES = {name for name in DECLARED if not name.startswith('python3-')}
ROSDEP_KEYS = {'numpy': 'python3-numpy', 'scipy': 'python3-scipy', 'yaml': 'python3-yaml'}
OPTIONAL = {
    'cvxpy', 'dask', 'distributed', 'llvmlite', 'matplotlib', 'numba', 'pyarrow', 'rosbags',
}  # fmt: skip


def source_files(package):
    files = sorted((ROOT / package).rglob('*.py'))
    assert files, f'no sources in {ROOT / package}'
    return files


def module_name(file):
    parts = file.relative_to(ROOT).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


def imported_packages(file):
    """Top-level names of all absolute imports in `file`, wherever they stand."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition('.')[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.add(node.module.partition('.')[0])
    return found


@pytest.fixture
def prefix(monkeypatch):
    """Where the ament index finds obs_ros, as `ros2 run` asks it."""
    if 'AMENT_PREFIX_PATH' not in os.environ:
        monkeypatch.setenv('AMENT_PREFIX_PATH', sys.prefix)
    return Path(get_package_prefix('obs_ros'))


@pytest.mark.parametrize('name', EXECUTABLES)
def test_executable_lies_where_ros2_run_looks(prefix, name):
    executable = prefix / 'lib' / 'obs_ros' / name
    assert executable.is_file()
    assert os.access(executable, os.X_OK)


def test_share_holds_manifest_layouts_and_parameter_files(prefix):
    share = prefix / 'share' / 'obs_ros'
    assert (share / 'package.xml').read_text() == (ROOT / 'package.xml').read_text()
    for folder in ('config', 'layouts'):
        ours = {file.name: file.read_text() for file in (ROOT / folder).iterdir()}
        assert ours and ours == {f.name: f.read_text() for f in (share / folder).iterdir()}


@pytest.mark.parametrize('package', ['obs_ros', 'plant_sim'])
def test_every_module_is_installed(prefix, package):
    places = list(prefix.glob(f'**/*-packages/{package}'))
    if not places:
        pytest.skip('linked to the sources, not installed')
    for file in source_files(package):
        installed = places[0].parent / file.relative_to(ROOT)
        assert installed.read_text() == file.read_text()


@pytest.mark.parametrize('name', EXECUTABLES)
def test_launcher_leads_to_the_script_of_pip(tmp_path, name):
    launcher = ROOT / 'tools' / 'launchers' / name
    assert os.access(launcher, os.X_OK)
    place = tmp_path / 'a prefix' / 'lib' / 'obs_ros' / name
    script = tmp_path / 'a prefix' / 'bin' / name
    for copy, text in (place, launcher.read_text()), (script, '#!/bin/sh\necho "$2"\nexit 3\n'):
        copy.parent.mkdir(parents=True)
        copy.write_text(text)
        copy.chmod(0o755)
    run = subprocess.run([place, 'one', 'two words'], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout) == (3, 'two words\n')


def test_manifest_is_valid():
    MANIFEST.validate()
    assert MANIFEST.package_format == 3
    assert MANIFEST.get_build_type() == 'ament_python'
    assert MANIFEST.licenses == ['Apache-2.0']


def test_versions_agree():
    (in_setup,) = re.findall(r"version='(.+?)'", (ROOT / 'setup.py').read_text())
    in_changelog = re.findall(r'## \[(\d.*?)\]', (ROOT / 'CHANGELOG.md').read_text())
    assert in_setup == MANIFEST.version
    assert metadata.version('obs_ros') == MANIFEST.version
    assert in_changelog[0] == MANIFEST.version


@pytest.mark.parametrize('package', ['obs_ros', 'plant_sim', 'docs', 'README.md'])
def test_nobody_is_sent_to_an_index_for_this_package(package):
    """It is in none: packages are named themselves, extras are those of a clone."""
    files = [ROOT / package] if package.endswith('.md') else sorted((ROOT / package).rglob('*'))
    texts = [file.read_text() for file in files if file.suffix in ('.md', '.py')]
    assert texts
    assert not any(re.search(r'obs_ros\[[a-z]+\]|pip install .?obs_ros', text) for text in texts)


@pytest.mark.parametrize('package', ['obs_ros', 'plant_sim'])
def test_imports_are_declared(package):
    for file in source_files(package):
        foreign = imported_packages(file) - sys.stdlib_module_names - OPTIONAL
        foreign -= {'obs_ros', 'plant_sim'}
        assert {ROSDEP_KEYS.get(name, name) for name in foreign} <= DECLARED, file


def test_estimation_never_imports_the_simulation():
    for file in source_files('obs_ros'):
        assert 'plant_sim' not in imported_packages(file), file


@pytest.mark.parametrize(
    ('package', 'blocked'),
    [('obs_ros', ROS_PACKAGES | {'plant_sim'}), ('plant_sim', ROS_PACKAGES)],
)
def test_everything_but_the_nodes_imports_without_ros(package, blocked):
    modules = {module_name(file) for file in source_files(package)} - TEMPLATES
    modules = sorted(name for name in modules if not name.startswith(ROS_SIDE))
    program = (
        'import importlib, sys\n'
        f'sys.modules.update(dict.fromkeys({sorted(blocked)}))\n'
        f'for name in {modules}: importlib.import_module(name)\n'
    )
    run = subprocess.run(
        [sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
