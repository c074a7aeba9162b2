"""Work on Dask: local processes, and schedulers and workers that are processes of their own."""

import os
import signal
from concurrent.futures import CancelledError
from unittest.mock import Mock

import pytest
from dask_processes import cluster, distributed, worker
from study_runs import GIVEN, bits, deadly, pid_of, recordings

from obs_ros.replay.recording import Source
from obs_ros.studies.cluster import SETTINGS, _results
from obs_ros.studies.runner import Where, carried_out
from obs_ros.studies.store import Store
from obs_ros.studies.study import Study
from obs_ros.studies.variants import variants
from obs_ros.studies.worker import Failure

pytestmark = pytest.mark.slow  # processes


@pytest.fixture(autouse=True)
def _installed():
    distributed()


def study(folder, store):
    """Five recordings by two variants."""
    paths = recordings(folder, 5)
    chosen = variants(GIVEN, ['process_noise=off,auto'])
    return Study.of(paths, chosen, Source(paths[0]), Store(folder / store))


def columns(asked):
    return {str(run): bits(result.columns) for run, result in asked.results()}


@pytest.fixture
def serial(tmp_path):
    """Return the columns of every run, done here one after the other."""
    asked = study(tmp_path, 'serial')
    list(asked.carry_out(asked.left(), Where()))
    return columns(asked)


def test_local_processes_share_the_work_with_one_thread_each():
    found = dict(carried_out(pid_of, [(k,) for k in range(40)], Where(jobs=2), chunk=3))
    assert [found[k][0] for k in range(40)] == list(range(40))
    assert len({pid for _, pid, _ in found.values()} - {os.getpid()}) == 2
    assert {threads for *_, threads in found.values()} == {'1'}


def test_a_run_that_kills_every_worker_is_given_up_and_the_others_are_done():
    found = dict(carried_out(deadly, [(k,) for k in range(4)], Where(jobs=1)))
    assert found.pop(1) == Failure(f'{SETTINGS.deaths + 1} workers died of it')
    assert found == {0: 0, 2: 2, 3: 3}


def test_a_worker_killed_half_way_costs_nothing_and_the_bits_are_those_of_serial_work(
    tmp_path, serial
):
    import multiprocessing

    asked = study(tmp_path, 'killed')
    done = []
    for run, why in asked.carry_out(asked.left(), Where(jobs=2)):
        done.append(run.key)
        if len(done) == 4:
            os.kill(multiprocessing.active_children()[0].pid, signal.SIGKILL)
        assert not why
    assert len(done) == len({*done}) == 10
    assert columns(asked) == serial


def test_a_scheduler_that_is_there_gives_the_same_bits_also_when_its_workers_die(tmp_path, serial):
    import psutil

    asked = study(tmp_path, 'scheduler')
    with cluster(tmp_path) as (address, (_, first, _)):
        done = []
        for run, why in asked.carry_out(asked.left(), Where(scheduler=address)):
            done.append(run.key)
            if len(done) == 4:  # the one that works; Dask's nanny starts another
                for child in psutil.Process(first.pid).children(recursive=True):
                    child.kill()
            assert not why
    assert len(done) == len({*done}) == 10
    assert columns(asked) == serial


def test_a_scheduler_without_workers_is_told_and_waited_for(tmp_path):
    with cluster(tmp_path, workers=0) as (address, started):
        told = []

        def say(line):
            told.append(line)
            started.append(worker(tmp_path, address))

        work = carried_out(divmod, [(7, 2)], Where(scheduler=address), say=say)
        assert list(work) == [(0, (3, 1))]
    assert told == [f'{address} has no workers yet: waiting for them']


def test_a_scheduler_that_is_not_there_is_one_line():
    with pytest.raises(OSError) as told:
        list(carried_out(divmod, [(7, 2)], Where(scheduler='tcp://127.0.0.1:9')))
    assert str(told.value).startswith('no Dask scheduler answers at tcp://127.0.0.1:9: start one')


def test_a_scheduler_that_ends_is_one_line_and_what_is_done_is_kept(tmp_path):
    asked = study(tmp_path, 'gone')
    done = []
    with cluster(tmp_path) as (address, (scheduler, *_)):
        with pytest.raises(OSError, match=f'the Dask scheduler at {address} is gone'):
            for run, _ in asked.carry_out(asked.left(), Where(scheduler=address)):
                done.append(run.key)
                scheduler.kill()
        assert 1 <= len(done) < 10
    left = study(tmp_path, 'gone').left()
    assert len(left) == 10 - len(done) and not {run.key for run in left} & {*done}


@pytest.mark.parametrize('lost', [ConnectionResetError('by peer'), CancelledError()])
@pytest.mark.parametrize('when', ['exception', 'result'])
def test_a_scheduler_that_ends_while_a_result_is_fetched_is_one_line(lost, when):
    import distributed as dask

    assert issubclass(dask.comm.CommClosedError, OSError)
    future = Mock(**{'cancelled.return_value': False, 'exception.return_value': None})
    getattr(future, when).side_effect = lost
    with pytest.raises(OSError) as told:
        _results(dask, future, 1, 'tcp://127.0.0.1:9')
    assert str(told.value) == 'the Dask scheduler at tcp://127.0.0.1:9 is gone'


def test_workers_of_another_version_are_refused_in_one_line(tmp_path):
    with (
        cluster(tmp_path, workers=1, OBS_ROS_BACKEND='numpy') as (address, _),
        pytest.raises(ValueError) as told,
    ):
        list(carried_out(divmod, [(7, 2)], Where(scheduler=address)))
    assert str(told.value) == (
        f'a worker at {address} has other versions: OBS_ROS_BACKEND numpy there, none here'
    )
