import dataclasses
import os

import pytest
from ball_and_beam import BALL
from study_runs import GIVEN, recordings

from obs_ros.replay.recording import Source
from obs_ros.replay.settings import setup
from obs_ros.studies import keys
from obs_ros.studies.keys import content, described, key


def test_a_recording_is_its_content_and_not_its_name(tmp_path):
    one, two = recordings(tmp_path, 2)
    other = tmp_path / 'copy.csv'
    other.write_bytes(one.read_bytes())
    assert content(one) == content(other) != content(two)


def test_a_folder_is_its_files_by_name(tmp_path):
    for bag, names in (('a', 'xy'), ('b', 'xy'), ('c', 'xz')):
        (tmp_path / bag).mkdir()
        for name in names:
            (tmp_path / bag / name).write_text(names[0])
    assert content(tmp_path / 'a') == content(tmp_path / 'b') != content(tmp_path / 'c')


def test_what_cannot_be_read_is_told(tmp_path):
    recordings(tmp_path, 1)
    with pytest.raises(OSError, match='does not exist: did you mean'):
        content(tmp_path / 'rig.csv')
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(ValueError, match='is a pipe or a device'):
        content(tmp_path / 'pipe')


def test_a_key_changes_with_all_that_a_result_depends_on(tmp_path, monkeypatch):
    source, chosen = Source(tmp_path), setup(GIVEN)
    usual = key('abc', source, chosen, False)
    assert usual == key('abc', Source(tmp_path / 'moved'), setup(dict(GIVEN)), False)
    others = [
        key('abd', source, chosen, False),
        key('abc', source, chosen, True),
        key('abc', dataclasses.replace(source, columns={'y': 'r'}), chosen, False),
        key('abc', source, setup({**GIVEN, 'seed': 1}), False),
        key('abc', source, setup({**GIVEN, 'observer': 'ekf'}), False),
    ]
    monkeypatch.setattr(keys, 'versions', lambda: {'obs_ros': 'another'})
    others.append(key('abc', source, chosen, False))
    assert len({usual, *others}) == 7


def test_a_model_is_its_variables_and_its_functions():
    def steeper(t, x, u, p):
        return x[1], 2.0 * p[0] * u[0] - p[1] * x[1] + p[2]

    assert described(BALL) == described(dataclasses.replace(BALL))
    assert described(BALL) != described(dataclasses.replace(BALL, dynamics=steeper))
    assert described(BALL) != described(dataclasses.replace(BALL, max_step=0.01))
