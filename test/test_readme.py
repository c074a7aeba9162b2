"""The README tells the truth about parameters."""

import re
import subprocess
from pathlib import Path

import pytest

from obs_ros.core.estimate import Outcome
from obs_ros.observers.base import OBSERVERS

ROOT = Path(__file__).parent.parent
README = (ROOT / 'README.md').read_text()


def test_every_parameter_stands_in_the_readme_as_it_is_declared() -> None:
    pytest.importorskip('rclpy')
    from obs_ros.core.parameter_spec import markdown_table
    from obs_ros.interface import parameters as estimator
    from obs_ros.interface.fleet import FLEET
    from plant_sim import fault_settings as faults
    from plant_sim import settings as simulator

    assert markdown_table((*estimator.CHOICE, *estimator.LIVE, *estimator.COMMON)) in README
    for text in (README, (ROOT / 'docs' / 'fleets.md').read_text()):
        assert markdown_table(FLEET) in text
    assert markdown_table((*simulator.CHOICE, *simulator.COMMON)) in README
    instruments = faults.sensor_parameters('<output>'), faults.actuator_parameters('<input>')
    assert markdown_table(row for rows in instruments for row in rows) in README


def test_every_setting_of_every_observer_stands_in_the_documentation() -> None:
    from obs_ros.interface.usage import settings_page

    assert (ROOT / 'docs' / 'observer-parameters.md').read_text() == settings_page()


@pytest.mark.parametrize('page', ['README.md', 'docs/which-observer.md'])
def test_every_observer_has_its_row_in_the_comparisons(page: str) -> None:
    text = (ROOT / page).read_text()
    for name in OBSERVERS:
        assert f'| `{name}` |' in text, name


def test_the_pendulum_of_the_readme_is_a_model() -> None:
    text = README.split('## Your own plant')[1].split('Plain functions')[0]
    scope: dict[str, object] = {}
    exec('\n'.join(line[4:] for line in text.splitlines() if line.startswith('    ')), scope)
    model = scope['PENDULUM']
    assert model.dynamics(0.0, (0.0, 1.0), (0.5,), (9.0, 0.1)) == (1.0, 0.5 - 0.1)


def test_every_file_that_the_readme_links_is_in_the_repository() -> None:
    links = [link.split('#')[0] for link in re.findall(r']\(([^)]+)\)', README)]
    links = [link for link in links if '://' not in link]
    assert 'docs/demo.png' in links
    git = ['git', 'ls-files', '--error-unmatch', '--', *links]
    tracked = subprocess.run(git, cwd=ROOT, capture_output=True, text=True)
    if 'not a git repository' in tracked.stderr:
        pytest.skip('not a git checkout')
    assert tracked.returncode == 0, tracked.stderr


def test_texts_that_are_long_are_shown_whole() -> None:
    """`ros2 topic echo` cuts what it shows at 128 characters, advice included."""
    pages = [README, *(page.read_text() for page in (ROOT / 'docs').glob('*.md'))]
    commands = re.findall(r'ros2 topic echo [^`\n]*(?:/diagnostics|/info)', '\n'.join(pages))
    assert len(commands) >= 4
    assert all('--full-length' in command for command in commands), commands


@pytest.mark.parametrize('page', ['README.md', 'docs/your-own-plant.md'])
def test_what_inputs_do_between_samples_is_told_where_inputs_are_described(page: str) -> None:
    assert re.search(r"interpolation.*'?linear.*mean", (ROOT / page).read_text(), re.DOTALL)


def test_every_figure_of_the_diagnostics_is_explained() -> None:
    from obs_ros.samples.gate import COUNTS as ENTERING
    from obs_ros.samples.successive_outputs import COUNTS as SUCCESSIVE
    from obs_ros.samples.window import COUNTS as OF_WINDOWS

    page = (ROOT / 'docs' / 'reading-the-diagnostics.md').read_text()
    source = (ROOT / 'obs_ros' / 'interface' / 'figures.py').read_text()
    yielded = re.findall(r"yield '([a-z_.]+)'", source)
    assert {'observer', 'last_outlier', 'last_break', 'predicted'} <= {*yielded}
    counted = {*ENTERING, *SUCCESSIVE, *OF_WINDOWS}
    assert [name for name in {*yielded, *counted} if f'`{name}`' not in page] == []


def test_every_outcome_stands_in_the_glossary() -> None:
    text = (ROOT / 'docs' / 'glossary.md').read_text().split('## Outcomes')[1]
    assert [outcome for outcome in Outcome if f'`{outcome.value}`' not in text] == []
