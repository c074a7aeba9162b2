import builtins

import pytest

from obs_ros.replay.extras import MissingPackageError
from obs_ros.studies import cluster
from obs_ros.studies.runner import MOST_JOBS, Where, carried_out


def test_without_a_place_the_work_is_done_here_in_order():
    assert list(carried_out(divmod, [(7, 2), (9, 4)], Where())) == [(0, (3, 1)), (1, (2, 1))]
    (first, failure), second = carried_out(divmod, [(1, 0), (4, 2)], Where())
    assert (first, second) == (0, (1, (2, 0)))
    assert failure.words.startswith("ZeroDivisionError('")


@pytest.mark.parametrize(
    ('place', 'message'),
    [
        ({'jobs': 0}, f'--jobs must be 1 to {MOST_JOBS}, not 0'),
        ({'jobs': MOST_JOBS + 1}, f'--jobs must be 1 to {MOST_JOBS}'),
        ({'jobs': 2, 'scheduler': 'tcp://127.0.0.1:1'}, 'give --jobs or --scheduler, not both'),
    ],
)
def test_a_place_that_is_none_is_refused(place, message):
    with pytest.raises(ValueError, match=message):
        Where(**place)


def test_only_work_elsewhere_needs_distributed(monkeypatch):
    def missing(module, what):
        raise MissingPackageError(f'{what} needs the package {module}')

    monkeypatch.setattr(cluster, 'require', missing)
    with pytest.raises(MissingPackageError, match='--scheduler needs the package distributed'):
        list(carried_out(divmod, [(7, 2)], Where(jobs=2)))
    assert list(carried_out(divmod, [(7, 2)], Where())) == [(0, (3, 1))]


def test_serial_work_imports_nothing_of_dask(monkeypatch):
    imported = builtins.__import__

    def watched(name, *others, **more):
        assert name.partition('.')[0] not in ('dask', 'distributed')
        return imported(name, *others, **more)

    monkeypatch.setattr(builtins, '__import__', watched)
    assert list(carried_out(abs, [(-1,)], Where())) == [(0, 1)]
