"""Recordings are known by their names, and refused with the reason."""

import os

import pytest
from ball_and_beam import made_up, write_table

from obs_ros.replay.recording import Source, check_file, open_recording
from obs_ros.replay.settings import setup

CHOSEN = setup({'model': 'ball_and_beam:BALL'})


def test_a_table_brings_its_samples(tmp_path):
    recording = open_recording(Source(write_table(tmp_path / 'a.csv', *made_up(20))), CHOSEN)
    samples = list(recording)
    assert len(samples) == 40 and recording.done == 1.0
    assert [sample.u is None for sample in samples[:4]] == [False, True, False, True]


@pytest.mark.parametrize(
    ('name', 'options', 'reason'),
    [
        ('a.csv', {'topics': {'output': '/x'}}, 'is a table: topics are for bags'),
        ('a.mcap', {'columns': {'t': 'time'}}, 'is a bag: columns and a period are for tables'),
        ('a.mcap', {'period': 0.1}, 'is a bag: columns and a period are for tables'),
        ('a.txt.gz', {}, 'is no recording known here: a bag is a folder or ends in .mcap or .db3'),
    ],
)
def test_what_does_not_suit_is_refused(tmp_path, name, options, reason):
    (tmp_path / name).write_text('t,u,y')
    with pytest.raises(ValueError) as caught:
        open_recording(Source(tmp_path / name, **options), CHOSEN)
    assert reason in str(caught.value)


def test_a_file_that_is_not_there_brings_one_of_a_like_name(tmp_path):
    (tmp_path / 'record.csv').write_text('')
    with pytest.raises(FileNotFoundError, match=r"does not exist: did you mean 'record.csv'"):
        open_recording(Source(tmp_path / 'recrod.csv'), CHOSEN)
    with pytest.raises(FileNotFoundError, match=r'does not exist$'):
        open_recording(Source(tmp_path / 'nowhere' / 'a.csv'), CHOSEN)


def test_a_pipe_is_not_read(tmp_path):
    os.mkfifo(tmp_path / 'pipe.csv')
    with pytest.raises(ValueError, match='is a pipe or a device: copy'):
        check_file(tmp_path / 'pipe.csv')
    check_file(tmp_path)
