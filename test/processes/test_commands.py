"""Every command of README and docs, as a newcomer gives it, terminal beside terminal."""

import csv
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from documents import (
    PAGES,
    RECIPES,
    ROOT,
    Command,
    Section,
    alike,
    block_commands,
    python_blocks,
    sections,
    shown_lines,
)
from patience import patience

pytest.importorskip('rclpy')
from ros import Ros
from session import Session
from translations import UntranslatableError, awaited, perform, translation

from obs_ros.core.model import names
from plant_sim.scenarios import load_scenario
from plant_sim.simulation import Simulation

DOCUMENTED = [section for page in PAGES for section in sections(page.read_text(), page.name)]
SHOWN = {page.name: shown_lines(page.read_text()) for page in RECIPES}
PARAMETERS = ROOT / 'config' / 'three_tank.yaml'


@pytest.fixture(scope='module')
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A prefix with the packages of tutorial and recipes in it, as colcon would leave it."""
    folder = tmp_path_factory.mktemp('workspace')
    shutil.copytree(ROOT / 'examples', folder / 'src')
    pip = [sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps', '--no-build-isolation',
           '--no-index', '--prefix', folder / 'install', *(folder / 'src').iterdir()]  # fmt: skip
    subprocess.run(pip, check=True, timeout=patience(30.0), cwd=folder)
    return folder / 'install'


@pytest.fixture(scope='module')
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A table of the three tanks, one window long and a bit."""
    path = tmp_path_factory.mktemp('recording') / 'tanks.csv'
    run = Simulation(load_scenario('three_tank'))
    with path.open('w') as file:
        table = csv.writer(file)
        table.writerow(('t', *names(run.model.inputs), *names(run.model.outputs)))
        for _ in range(1200):
            instant = run.sample()
            table.writerow((instant.t, *instant.u, *instant.y))
    return path


@pytest.fixture
def session(
    ros: Ros, tmp_path: Path, workspace: Path, recording: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Session]:
    """Terminals in which the workspace is sourced."""
    before = os.environ.get('AMENT_PREFIX_PATH', sys.prefix)
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{workspace}:{before}')
    (modules,) = workspace.glob('lib/python*/site-packages')
    monkeypatch.setenv('PYTHONPATH', str(modules))
    files = {'RECORDING': str(recording), 'FILE': str(PARAMETERS)}
    files['REPLAY'] = f'{recording} --params {PARAMETERS}'
    session = Session(ros, tmp_path, files)
    yield session
    session.kill()


@pytest.mark.slow
@pytest.mark.parametrize('section', DOCUMENTED, ids=str)
def test_what_is_documented_works(session: Session, section: Section) -> None:
    for block in section.blocks:
        perform(session, block)
    session.close()
    for line in SHOWN.get(section.page, ()):
        assert any(alike(line, printed) for printed in session.printed), line


def test_every_documented_command_can_be_tried() -> None:
    commands = [command for section in DOCUMENTED for block in section.blocks for command in block]
    assert len(commands) >= 40
    for command in commands:
        translation(command)
        awaited(command)


@pytest.mark.parametrize(
    'block',
    [
        'docker run obs_ros',
        'ros2 topic pub /plant/output std_msgs/msg/Float64',
        'ros2 run other_package node',
        'make demo && rosdep install obs_ros',
        'ros2 param set /estimator deadline 2.0  # once the moon is full',
    ],
)
def test_a_command_that_is_new_is_not_taken_for_tried(block: str) -> None:
    with pytest.raises(UntranslatableError):
        for command in block_commands(block, 'here:1'):
            translation(command)
            awaited(command)


@pytest.mark.parametrize(
    ('printed', 'same'),
    [('| r0 | 1.02 (-0.5 to 2) |', True), ('| r0  |  1.0 (-0.49 to 2.05) |', True),
     ('| r0 | 1.1 (-0.5 to 2) |', False), ('| r0 | 1.02 (0.5 to 2) |', False),
     ('| r1 | 1.02 (-0.5 to 2) |', False), ('| r0 | 1.02 (-0.5 to 2) | 3 |', False),
     ('| r0 | 1.02 (-0.5 to ?) |', False)],
)  # fmt: skip
def test_printed_figures_are_compared_within_a_tolerance(printed: str, same: bool) -> None:
    assert alike('| r0 | 1.02 (-0.5 to 2) |', printed) is same


@pytest.mark.parametrize('page', RECIPES, ids=lambda page: page.stem)
def test_a_recipe_fits_a_screen_and_shows_its_model_as_it_is(page: Path) -> None:
    text = page.read_text()
    assert len(text.splitlines()) <= 45
    files = re.findall(r'\]\((\.\./[^)#]+)\)', text)
    sources = [(page.parent / file).resolve() for file in files]
    assert all(source.exists() for source in sources), files
    for block in python_blocks(text):
        assert any(block.strip() in source.read_text() for source in sources if source.is_file())


PAGE = """# First

Text with `make help`, `ros2 run` and `name`.

    import numpy as np
    x = 1

A file:

    /**/estimator:
      ros__parameters: {a: 1}

## Second

- a list:
      not code, since a list goes on

Before code:

    ros2 run obs_ros estimator --ros-args -p a:=1 \\
        -p 'b:=two words'                      # in a terminal
    cd .. && make test

```bash
ros2 param set /estimator x 1
```

```python
print('no command')
y = 2
```
"""


def test_commands_are_found_where_they_stand() -> None:
    first, second = sections(PAGE, 'page')
    assert (first.heading, second.heading) == ('First', 'Second')
    assert [[c.words for c in block] for block in first.blocks] == [[('make', 'help')]]
    node, shell = second.blocks
    assert node == [
        Command(
            ('ros2', 'run', 'obs_ros', 'estimator', '--ros-args', '-p', 'a:=1', '-p',
             'b:=two words'), 'page:20', 'in a terminal',
        ),
        Command(('cd', '..'), 'page:20'),
        Command(('make', 'test'), 'page:20'),
    ]  # fmt: skip
    assert [c.words for c in shell] == [('ros2', 'param', 'set', '/estimator', 'x', '1')]
