import pickle

import pytest

from obs_ros.studies.versions import versions
from obs_ros.studies.worker import Differs, Failure, called, packed, unpacked


def test_calls_are_done_in_their_order():
    assert unpacked(packed(divmod, [(7, 2), (9, 4)]), versions()) == [(3, 1), (2, 1)]


@pytest.mark.parametrize(
    ('work', 'argument', 'words'),
    [
        (int, 'x', "invalid literal for int() with base 10: 'x'"),
        (open, '/no/such/file', "[Errno 2] No such file or directory: '/no/such/file'"),
        ({}.pop, 'key', "KeyError('key')"),
    ],
)
def test_an_exception_is_a_failure_in_one_line(work, argument, words):
    failure = called(work, (argument,))
    assert failure.words == words
    assert failure.details.startswith('Traceback')


def test_other_versions_are_told_before_anything_is_read():
    here = {**versions(), 'numpy': '1.0'}
    found = unpacked(b'not even a pickle', here)
    assert isinstance(found, Differs)
    assert found.words == f'numpy {versions()["numpy"]} there, 1.0 here'


def test_only_functions_of_modules_are_sent():
    with pytest.raises((pickle.PicklingError, AttributeError)):
        packed(lambda: 0, [()])
    assert not Failure('why').details
