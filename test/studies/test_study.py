import pytest
from study_runs import GIVEN, bits, recordings

from obs_ros.replay.recording import Source
from obs_ros.studies.runner import Where
from obs_ros.studies.store import Store
from obs_ros.studies.study import Study, labels
from obs_ros.studies.variants import variants


@pytest.fixture
def study(tmp_path):
    """Return the study of three recordings and two variants, made anew at each call."""
    paths = recordings(tmp_path, 3)
    chosen = variants({**GIVEN, 'observer': 'ekf', 'noise.y': 1e-4}, ['seed=0,1'])

    def made(*others):
        store = Store(tmp_path / 'results')
        return Study.of([*paths, *others], chosen, Source(paths[0]), store)

    return made


def test_every_recording_is_run_with_every_variant_in_order(study):
    asked = study()
    done = [str(run) for run, why in asked.carry_out(asked.left(), Where()) if not why]
    assert done == [f'rig{k}.csv with seed={seed}' for k in (1, 2, 3) for seed in (0, 1)]
    found = [(run.labels, len(result)) for run, result in asked.results()]
    assert found[1] == ({'recording': 'rig1.csv', 'seed': '1'}, 110)
    assert len(found) == 6 and asked.missing == []


def test_no_run_is_done_twice(study):
    first = study()
    steps = first.carry_out(first.left(), Where())
    done = [next(steps)[0].key for _ in range(4)]
    steps.close()  # stopped
    again = study()
    left = again.left()
    assert len(left) == 2 and not {run.key for run in left} & {*done}
    assert len(list(again.carry_out(left, Where()))) == 2
    assert study().left() == []


def test_the_same_content_is_run_once_and_told_of_both(study, tmp_path):
    copy = tmp_path / 'copy.csv'
    copy.write_bytes((tmp_path / 'rig1.csv').read_bytes())
    asked = study(copy)
    assert (len(asked.runs), len(asked.left())) == (8, 6)
    list(asked.carry_out(asked.left(), Where()))
    found = {str(run): bits(result.columns) for run, result in asked.results()}
    assert len(found) == 8
    assert found['copy.csv with seed=1'] == found['rig1.csv with seed=1']


def test_what_cannot_be_read_leaves_the_others_alone(study, tmp_path):
    broken = tmp_path / 'broken.csv'
    broken.write_text('t,u,y\n0.0,0.0\n')
    asked = study(tmp_path / 'rig9.csv', broken)
    told = [(str(run), why) for run, why in asked.carry_out(asked.left(), Where()) if why]
    assert [name for name, _ in told] == ['broken.csv with seed=0', 'broken.csv with seed=1']
    assert all(why.endswith('broken.csv:2: 2 fields, but 3 columns') for _, why in told)
    unreadable, *failed = asked.missing
    assert unreadable[0] == 'rig9.csv' and 'does not exist: did you mean' in unreadable[2]
    assert [each[:2] for each in failed] == [('broken.csv', 'seed=0'), ('broken.csv', 'seed=1')]
    assert len(list(asked.results())) == 6
    # What failed is tried again.
    assert [run.recording for run in study(broken).left()] == ['broken.csv'] * 2


def test_seeds_and_noise_are_those_of_the_run_not_of_its_place(study):
    asked = study()
    list(asked.carry_out(asked.left(), Where()))
    before = {str(run): bits(result.columns) for run, result in asked.results()}
    asked.store.forget()
    list(asked.carry_out(asked.left()[::-1], Where()))
    assert {str(run): bits(result.columns) for run, result in asked.results()} == before


def test_recordings_of_one_name_are_told_apart_by_their_folders(tmp_path):
    paths = [tmp_path / 'a' / 'x.csv', tmp_path / 'b' / 'x.csv', tmp_path / 'y.csv']
    assert labels(paths) == ['a/x.csv', 'b/x.csv', 'y.csv']
