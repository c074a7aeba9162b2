"""The house: a file imports from its own folder and from those above it, never in a circle."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# From the ground up. A folder inside another comes after it.
FLOORS = (
    'core', 'models', 'integration', 'optimization', 'samples', 'inference', 'inference.jumps',
    'inference.assessment', 'horizon', 'observers', 'observers.kalman_filters',
    'observers.papers', 'observers.papers.design', 'interface', 'pages', 'replay',
    'studies', 'cli', 'ros',
)  # fmt: skip
PACKAGES = ('obs_ros', 'plant_sim', 'demo', 'benchmarks')
ROS = {
    'rclpy', 'ament_index_python', 'builtin_interfaces', 'diagnostic_msgs', 'lifecycle_msgs',
    'rcl_interfaces', 'rosgraph_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs',
}  # fmt: skip


def modules() -> dict[str, Path]:
    """Return every module of the packages by its dotted name."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob('*.py'):
            parts = path.relative_to(ROOT).with_suffix('').parts
            found['.'.join(parts[:-1] if parts[-1] == '__init__' else parts)] = path
    return found


MODULES = modules()


def imported(name: str) -> set[str]:
    """Return the modules that a module imports, wherever in it; those of the packages in full."""
    found = set()
    for node in ast.walk(ast.parse(MODULES[name].read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            inside = {f'{node.module}.{alias.name}' for alias in node.names}
            known = inside & set(MODULES)
            found |= known
            if len(known) < len(inside):
                found.add(node.module)
    return found


def floor(name: str) -> int | None:
    """Return the floor of a module of obs_ros; None for the roof, which only looks names up."""
    inside = name.removeprefix('obs_ros.')
    if inside.endswith('.__main__'):  # the door to a command
        inside = 'cli'
    fitting = [f for f in FLOORS if inside == f or inside.startswith(f'{f}.')]
    return FLOORS.index(max(fitting, key=len)) if fitting else None


@pytest.mark.parametrize('name', [n for n in MODULES if n.startswith('obs_ros.')])
def test_no_arrow_runs_back_up(name: str) -> None:
    own = floor(name)
    assert own is not None, f'{name} is in no room of the house'
    for other in imported(name):
        if other.startswith('obs_ros.'):
            theirs = floor(other)
            assert theirs is not None and theirs <= own, f'{name} imports {other}'


def test_nothing_is_imported_in_a_circle() -> None:
    # The roof looks its names up when they are asked for.
    arrows = {
        name: set() if name == 'obs_ros' else imported(name) & set(MODULES) - {name}
        for name in MODULES
    }
    while leaves := {name for name, others in arrows.items() if not others & set(arrows)}:
        for name in leaves:
            del arrows[name]
    circle = {name: sorted(others & set(arrows)) for name, others in arrows.items()}
    assert not circle


@pytest.mark.parametrize(
    'name', [n for n in MODULES if n.split('.')[0] in ('obs_ros', 'plant_sim')]
)
def test_only_the_ros_side_imports_ros(name: str) -> None:
    if name.startswith('obs_ros.ros.') or name == 'plant_sim.node':
        return
    found = {other.split('.')[0] for other in imported(name)} & ROS
    assert not found, f'{name} imports {found}'
    assert not {other for other in imported(name) if other.startswith('obs_ros.ros')}


@pytest.mark.parametrize('page', ['architecture.md', 'glossary.md'])
def test_the_pages_of_the_house_name_what_is_there(page: str) -> None:
    rooms = '|'.join({floor.split('.')[0] for floor in FLOORS})
    named = re.findall(rf'(?<![\w/])(?:{rooms})/[a-z_/]*', (ROOT / 'docs' / page).read_text())
    assert len(named) > 20
    for name in named:
        place = ROOT / 'obs_ros' / name
        assert place.is_dir() or place.with_suffix('.py').is_file(), name


def test_the_makefile_names_tests_that_are_there() -> None:
    named = re.findall(r'\$\(pytest\) (test[\w/.]*)', (ROOT / 'Makefile').read_text())
    assert len(named) == 2
    assert [place for place in named if not (ROOT / place).exists()] == []


def test_the_package_does_not_know_the_simulator() -> None:
    for name in MODULES:
        if name.startswith('obs_ros'):
            assert not {o for o in imported(name) if o.split('.')[0] in ('plant_sim', 'benchmarks')}


def test_a_benchmark_does_not_know_another() -> None:
    topics = {path.parent.name for path in (ROOT / 'benchmarks').glob('*/__main__.py')}
    for name in MODULES:
        parts = name.split('.')
        if parts[0] == 'benchmarks' and parts[1:2] and parts[1] in topics:
            found = {o.split('.')[1] for o in imported(name) if o.startswith('benchmarks.')}
            assert not found & topics - {parts[1]}, f'{name} imports {found}'


def test_every_module_has_its_test_file() -> None:
    """At the same place below test/; the tests of `ros/` are those of nodes."""
    missing = []
    for name, path in MODULES.items():
        package, *parts = name.split('.')
        tree = ast.parse(path.read_text())
        defines = any(isinstance(n, ast.FunctionDef | ast.ClassDef) for n in ast.walk(tree))
        if package in ('demo', 'benchmarks') or path.stem.startswith('__') or not defines:
            continue
        place = [{'ros': 'node'}.get(part, part) for part in parts[:-1]]
        place = ['plant_sim', *place] if package == 'plant_sim' else place
        if not ROOT.joinpath('test', *place, f'test_{parts[-1]}.py').is_file():
            missing.append(name)
    assert missing == []


def decompositions(path: Path) -> set[str]:
    """Return the functions of np.linalg that a module uses and that raise where data have none."""
    nodes = [
        node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Attribute)
    ]
    return {
        node.attr for node in nodes
        if isinstance(node.value, ast.Attribute) and node.value.attr == 'linalg'
    } - {'norm', 'LinAlgError'}  # fmt: skip


def test_matrices_are_decomposed_in_one_place_which_never_raises() -> None:
    """The design of gains apart, which looks at no data, and the recorder's names of functions."""
    elsewhere = ('obs_ros.core.linear_algebra', 'obs_ros.core.substitutes',
                 'obs_ros.observers.papers.design')  # fmt: skip
    wrong = {
        name: found
        for name, path in MODULES.items()
        if name.startswith('obs_ros.') and not name.startswith(elsewhere)
        and (found := decompositions(path))
    }  # fmt: skip
    assert not wrong, 'use obs_ros.core.linear_algebra'
