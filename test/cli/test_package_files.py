import os
import shlex
import xml.etree.ElementTree
from pathlib import Path

import pytest
import yaml

from obs_ros.cli.first_guess import Guess
from obs_ros.cli.package_files import package_files, write_package
from obs_ros.cli.package_signals import Signal, Signals
from obs_ros.cli.recorded_ranges import assumed

SIGNALS = Signals((Signal('cur', 'A', 'cur [A]'),), (Signal('volt', 'V', 'volt'),), 'clock')
GUESS = Guess(SIGNALS, assumed(SIGNALS, None))
TEXTS = {'README.md': 'read', 'cell/plant.py': 'PLANT', 'resource/cell': ''}


def everything(folder: Path) -> dict[str, str]:
    return {str(f.relative_to(folder)): f.read_text() for f in folder.rglob('*') if f.is_file()}


def test_a_package_is_whole(tmp_path):
    made = package_files('cell', GUESS, Path('/rec/a b.csv'), 0.5)
    assert made.keys() >= {'cell/__init__.py', 'cell/plant.py', 'setup.py', 'resource/cell'}
    assert xml.etree.ElementTree.fromstring(made['package.xml']).findtext('name') == 'cell'
    for place, text in made.items():
        if place.endswith('.py'):
            compile(text, place, 'exec')
    given = yaml.safe_load(made['config/plant.yaml'])
    estimator = given['/**/estimator']['ros__parameters']
    assert estimator['model'] == 'cell.plant:PLANT'
    assert estimator['window'] == {'duration': 10.0, 'period': 5.0}
    assert given['/**']['ros__parameters']['signals']['cur'] == {
        'topic': 'plant/input', 'type': 'sensor_msgs/msg/JointState', 'field': 'position[cur]',
    }  # fmt: skip


def test_the_readme_replays_the_table_as_it_was_read():
    text = package_files('cell', GUESS, Path('/rec/a b.csv'), 0.5)['README.md']
    (line,) = [line for line in text.splitlines() if 'obs_ros.replay' in line]
    assert shlex.split(line)[3:] == [
        '/rec/a b.csv', '--params', 'config/plant.yaml', '--column', 't=clock',
        '--column', 'cur=cur [A]', '--period', '0.5',
    ]  # fmt: skip
    assert 'obs_ros.replay' not in package_files('cell', GUESS, None)['README.md']


def test_the_guess_is_called_one_wherever_a_user_looks():
    made = package_files('cell', GUESS, None)
    assert 'first guess, not your plant' in made['README.md']
    assert made['cell/plant.py'].count('TO REPLACE') == 2
    assert "reference='a first guess" in made['cell/plant.py']  # check_model's first line


def test_files_come_to_be_together(tmp_path):
    write_package(tmp_path / 'cell', TEXTS)
    assert everything(tmp_path) == {f'cell/{place}': text for place, text in TEXTS.items()}


def test_what_fails_on_the_way_leaves_nothing(tmp_path, monkeypatch):
    write = Path.write_text

    def full(self, *args, **options):
        if self.name == 'plant.py':
            raise OSError(28, 'No space left on device')
        return write(self, *args, **options)

    monkeypatch.setattr(Path, 'write_text', full)
    with pytest.raises(OSError, match='No space left'):
        write_package(tmp_path / 'cell', TEXTS)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('kind', ['file', 'folder', 'dangling link'])
def test_nothing_is_overwritten(tmp_path, kind):
    target = tmp_path / 'cell'
    {'file': target.touch, 'folder': target.mkdir,
     'dangling link': lambda: target.symlink_to('nowhere')}[kind]()  # fmt: skip
    with pytest.raises(ValueError, match='choose another name, or move what is there'):
        write_package(target, TEXTS)
    assert [each.name for each in tmp_path.iterdir()] == ['cell']
    assert not target.is_dir() or not list(target.iterdir())


def test_a_folder_that_came_meanwhile_is_not_replaced(tmp_path, monkeypatch):
    target = tmp_path / 'cell'
    target.mkdir()
    (target / 'mine').write_text('kept')
    monkeypatch.setattr(os.path, 'lexists', lambda path: False)
    with pytest.raises(OSError):
        write_package(target, TEXTS)
    assert everything(tmp_path) == {'cell/mine': 'kept'}


def test_the_folder_to_write_in_must_be_there(tmp_path):
    with pytest.raises(ValueError, match='make the folder first'):
        write_package(tmp_path / 'no' / 'cell', TEXTS)
