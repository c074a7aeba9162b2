"""Packages that are missing are named, with the remedy."""

import math

import pytest

from obs_ros.replay.extras import MissingPackageError, require


def test_a_module_that_is_there_is_returned():
    assert require('math', 'counting') is math


def test_a_missing_package_says_how_to_get_it():
    with pytest.raises(MissingPackageError) as caught:
        require('no_such_package.part', 'drawing')
    assert str(caught.value) == (
        'drawing needs the package no_such_package: pip install no_such_package'
    )


def test_what_a_package_itself_lacks_is_another_error(tmp_path, monkeypatch):
    (tmp_path / 'half_there.py').write_text('import no_such_package')
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="No module named 'no_such_package'") as caught:
        require('half_there', 'drawing')
    assert not isinstance(caught.value, MissingPackageError)
