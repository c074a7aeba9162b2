"""The README tells the truth about parameters."""

from pathlib import Path

import pytest

README = (Path(__file__).parent.parent / 'README.md').read_text()


def test_every_parameter_stands_in_the_readme_as_it_is_declared() -> None:
    pytest.importorskip('rclpy')
    from obs_ros.node import settings as estimator
    from obs_ros.node.knob import markdown_table
    from plant_sim import settings as simulator

    assert markdown_table((*estimator.CHOICE, *estimator.LIVE, *estimator.COMMON)) in README
    assert markdown_table((*simulator.CHOICE, *simulator.COMMON)) in README


def test_the_pendulum_of_the_readme_is_a_model() -> None:
    text = README.split('## Your own plant')[1].split('Plain functions')[0]
    scope: dict[str, object] = {}
    exec('\n'.join(line[4:] for line in text.splitlines() if line.startswith('    ')), scope)
    model = scope['PENDULUM']
    assert model.dynamics(0.0, (0.0, 1.0), (0.5,), (9.0, 0.1)) == (1.0, 0.5 - 0.1)
