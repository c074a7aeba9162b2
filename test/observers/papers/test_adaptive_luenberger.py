"""Tests of obs_ros.observers.papers.adaptive_luenberger, against Gremling & Passino 2000."""

from typing import Any

import pytest
from observer_form import MINIMUM_PHASE, NON_MINIMUM_PHASE, experiment
from plants import observer_form

from obs_ros.observers.papers.adaptive_luenberger import AdaptiveLuenbergerObserver


@pytest.mark.parametrize(
    ('p', 'normalised', 'paper'),
    [(MINIMUM_PHASE, False, (4365.23, 3427.46)), (NON_MINIMUM_PHASE, True, (6320.0, 8348.1))],
)
def test_the_adaptive_observer_makes_the_papers_errors(
    p: Any, normalised: bool, paper: tuple[float, float]
) -> None:
    observer = AdaptiveLuenbergerObserver(observer_form(), normalised=normalised)
    assert experiment(observer, p)[1:] == pytest.approx(paper, rel=0.005)
