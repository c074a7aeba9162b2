"""Tests of obs_ros.core.kernel_linking: loaded code takes little memory, and links all the same."""

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('numba')

from obs_ros.core.jit import accelerated


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: Any) -> Path:
    """A cache folder that is empty."""
    monkeypatch.setenv('OBS_ROS_CACHE', str(tmp_path))
    return tmp_path


def doubled() -> Any:
    """Return the same function anew, as in another process."""

    def double(x: float) -> float:
        return 2.0 * x

    return accelerated(double)


def library(function: Any) -> Any:
    ((compiled,),) = [function.overloads.values()]
    return compiled.library


def test_what_is_compiled_later_links_what_was_loaded_and_is_stored_as_well(cache: Path) -> None:
    assert doubled()(3.0) == 6.0
    loaded = doubled()
    assert loaded(3.0) == 6.0
    assert sum(loaded.stats.cache_hits.values()) == 1

    def again() -> Any:
        def quadruple(x: float) -> float:
            return loaded(loaded(x))  # type: ignore[no-any-return]

        return accelerated(quadruple)

    compiled, reloaded = again(), again()
    assert (compiled(3.0), reloaded(5.0)) == (12.0, 20.0)
    assert sum(compiled.stats.cache_hits.values()) == 0
    assert sum(reloaded.stats.cache_hits.values()) == 1


def test_no_parsed_code_is_kept_of_what_was_loaded(cache: Path) -> None:
    compiled, loaded = doubled(), doubled()
    assert (compiled(3.0), loaded(3.0)) == (6.0, 6.0)
    assert library(compiled)._shared_module is not None  # Numba parses it to store it
    assert library(loaded)._shared_module is None
    anew = library(loaded)._get_module_for_linking()
    assert any('double' in f.name and not f.is_declaration for f in anew.functions)
