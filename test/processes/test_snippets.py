"""The Python of the page on sensors, as a reader pastes it: every estimate holds the truth."""

import sys
from pathlib import Path

import pytest
from documents import ROOT, python_blocks

from obs_ros import Estimate

TRUTH = {'stiffness': 8.0, 'friction': 0.3, 'torque.delay': 0.1}
DEVIATIONS = 4.0  # that an estimate may be off: of some twenty, by chance in one of 800 runs
# One exact window in a hundred is taken for approximate by chance: its residual is not white.
OUTCOMES = ('converged', 'at_bound', 'approximate')
BLOCKS = python_blocks((ROOT / 'docs' / 'sensors.md').read_text())


@pytest.fixture
def tutorial(monkeypatch: pytest.MonkeyPatch) -> Path:
    """The package of the tutorial, importable."""
    folder = ROOT / 'examples' / 'my_plant'
    monkeypatch.syspath_prepend(str(folder))
    for name in [name for name in sys.modules if name.partition('.')[0] == 'my_plant']:
        monkeypatch.delitem(sys.modules, name)
    return folder


@pytest.mark.slow
@pytest.mark.usefixtures('tutorial')
def test_every_estimate_of_the_page_holds_the_truth() -> None:
    scope: dict[str, object] = {}
    judged = 0
    for block in BLOCKS:
        exec(block, scope)
        estimates = {n: scope.pop(n) for n in list(scope) if isinstance(scope[n], Estimate)}
        for name, estimate in estimates.items():
            assert isinstance(estimate, Estimate)
            assert estimate.outcome in OUTCOMES, (block, estimate)
            for parameter, value in estimate.parameters.items():
                off = abs(value - TRUTH[parameter]) / estimate.stddev[parameter]
                assert off < DEVIATIONS, (block, name, parameter, value, off)
                judged += 1
    assert judged >= 18
