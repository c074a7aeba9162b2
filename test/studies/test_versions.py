import numpy as np

from obs_ros.studies.versions import SOURCES, differences, sources, versions


def test_all_that_bits_depend_on_has_its_version(monkeypatch):
    found = versions()
    assert found['numpy'] == np.__version__
    assert found['obs_ros'] == sources(SOURCES) and len(found['obs_ros']) == 12
    assert set(found) == {'obs_ros', 'python', 'numpy', 'scipy', 'numba', 'OBS_ROS_BACKEND'}


def test_sources_are_told_apart_by_content_and_place(tmp_path):
    for name, file, text in (('a', 'x.py', '1'), ('b', 'x.py', '1'), ('c', 'y.py', '1'),
                             ('d', 'x.py', '2')):  # fmt: skip
        (tmp_path / name).mkdir()
        (tmp_path / name / file).write_text(text)
        (tmp_path / name / 'notes.txt').write_text(name)
    one, same, moved, changed = (sources(tmp_path / name) for name in 'abcd')
    assert one == same
    assert len({one, moved, changed}) == 3


def test_differences_are_named_with_both_versions():
    here = {'numpy': '2.4', 'python': '3.11', 'numba': ''}
    assert differences(here, dict(here)) == ''
    there = {'numpy': '1.26', 'python': '3.11', 'numba': '0.68'}
    assert differences(here, there) == 'numba 0.68 there, none here, numpy 1.26 there, 2.4 here'
