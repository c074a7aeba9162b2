from pathlib import Path

from obs_ros.core.parameter_spec import markdown_table
from obs_ros.pages.settings import VIEW, usage, wanted


def test_it_listens_on_this_machine_unless_told_otherwise():
    defaults = {spec.name: spec.default for spec in VIEW}
    assert defaults['host'] == '127.0.0.1'
    # No remote caller opens it to the network.
    assert all(spec.read_only for spec in VIEW)


def test_all_estimators_are_shown_or_those_named():
    assert wanted(('all',), '/a/estimator')
    assert wanted(('/a/estimator',), '/a/estimator')
    assert not wanted(('/a/estimator',), '/b/estimator')


def test_the_help_names_every_parameter():
    text = usage()
    assert text.startswith('usage: ros2 run obs_ros view')
    assert all(f'  {spec.name} (' in text for spec in VIEW)
    assert "by the model's names" not in text


def test_the_page_of_the_documentation_has_every_parameter():
    text = (Path(__file__).parents[2] / 'docs' / 'view.md').read_text()
    assert markdown_table(VIEW) in text
