"""The layouts for Foxglove and PlotJuggler name what nodes of the three tanks publish."""

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from ros import Ros
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from obs_ros.interface.vectors import TOPICS
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import LATCHED
from plant_sim.node import Simulator

LAYOUTS = Path(__file__).parents[2] / 'layouts'
FOXGLOVE = json.loads((LAYOUTS / 'foxglove.json').read_text())
PLOTJUGGLER = ET.parse(LAYOUTS / 'plotjuggler.xml').getroot()
PANELS = FOXGLOVE['configById']
# /topic.field[index], and arithmetic on it.
PATH = re.compile(r'(?P<topic>[\w/]+)\.(?P<field>[a-z]+)\[(?P<index>\d+)\](\.@mul\((-?\d+)\))?')
CURVE = re.compile(r'(?P<topic>/\w+/\w+)/(?P<name>\w+)/(?P<field>\w+)')


def foxglove_paths():
    return [
        path for name, panel in PANELS.items() if name.startswith('Plot!')
        for path in panel['paths']
    ]  # fmt: skip


def plotjuggler_curves():
    return [curve.get('name') for curve in PLOTJUGGLER.iter('curve')]


def topics():
    found = {PATH.fullmatch(path['value'])['topic'] for path in foxglove_paths()}
    return sorted(found | {CURVE.fullmatch(curve)['topic'] for curve in plotjuggler_curves()})


@pytest.fixture(scope='module')
def told():
    """A message of each topic that a layout names, and of /diagnostics, from started nodes."""
    pytest.importorskip('rclpy')
    ros = Ros()
    try:
        estimator = ros.start(Estimator, window__duration=100.0, deadline=60.0)
        ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=60.0)
        ros.start(Simulator, speed=100.0)
        heard = {topic: ros.listen(topic, JointState) for topic in topics()}
        heard['/estimator/outcome'] = ros.listen('/estimator/outcome', String, LATCHED)
        heard['/diagnostics'] = ros.listen('/diagnostics', DiagnosticArray)
        ros.spin_until(lambda: all(heard.values()), timeout=60.0)
        return {topic: messages[-1] for topic, messages in heard.items()}, heard['/diagnostics']
    finally:
        ros.close()


@pytest.mark.parametrize('path', foxglove_paths(), ids=lambda path: path['value'])
def test_every_path_of_foxglove_leads_to_the_number_that_its_label_names(told, path):
    topic, field, index = PATH.fullmatch(path['value']).group('topic', 'field', 'index')
    message = told[0][topic]
    assert path['label'].split()[0] == message.name[int(index)]
    assert isinstance(getattr(message, field)[int(index)], float)
    assert path['timestampMethod'] == 'headerStamp' and message.header.stamp.sec > 0


@pytest.mark.parametrize('curve', plotjuggler_curves())
def test_every_curve_of_plotjuggler_is_published(told, curve):
    topic, name, field = CURVE.fullmatch(curve).group('topic', 'name', 'field')
    message = told[0][topic]
    assert isinstance(getattr(message, field)[message.name.index(name)], float)


def test_foxglove_shows_outcome_and_diagnostics_by_the_names_that_the_node_gives_them(told):
    messages, diagnostics = told
    topic, _, field = PANELS['RawMessages!outcome']['topicPath'].partition('.')
    assert json.loads(getattr(messages[topic], field))['outcome']
    statuses = {(s.name, s.hardware_id) for array in diagnostics for s in array.status}
    shown = PANELS['DiagnosticStatusPanel!estimator']
    assert (shown['selectedName'], shown['selectedHardwareId']) in statuses
    assert {panel['topicToRender'] for panel in PANELS.values() if 'topicToRender' in panel} == {
        '/diagnostics'
    }


def test_the_bag_of_a_replay_fills_every_view_but_residuals():
    """It has what windows tell; predictions, truth and outcome are of running nodes."""
    recorded = {f'/estimator/{topic}' for topic in TOPICS}
    for name, panel in PANELS.items():
        if name.startswith('Plot!') and name != 'Plot!residual':
            assert {PATH.fullmatch(p['value'])['topic'] for p in panel['paths']} & recorded, name
    for tab in PLOTJUGGLER.findall('tabbed_widget/Tab'):
        for area in tab.iter('DockArea') if tab.get('tab_name') != 'residuals' else ():
            curves = [CURVE.fullmatch(curve.get('name')) for curve in area.iter('curve')]
            assert {curve['topic'] for curve in curves} & recorded, area.get('name')


def leaves(layout):
    if isinstance(layout, str):
        return [layout]
    assert layout['direction'] in ('row', 'column') and 0 < layout['splitPercentage'] < 100
    return [*leaves(layout['first']), *leaves(layout['second'])]


def test_foxglove_lays_out_each_panel_once():
    assert sorted(leaves(FOXGLOVE['layout'])) == sorted(PANELS)


def test_splitters_of_plotjuggler_hold_as_many_areas_as_they_say():
    tabs = PLOTJUGGLER.findall('tabbed_widget/Tab')
    assert [tab.get('tab_name') for tab in tabs] == [
        'parameters', 'states', 'residuals', 'standard deviations'
    ]  # fmt: skip
    for splitter in PLOTJUGGLER.iter('DockSplitter'):
        sizes = [float(size) for size in splitter.get('sizes').split(';')]
        assert len(sizes) == int(splitter.get('count')) == len(splitter.findall('DockArea'))
        assert abs(sum(sizes) - 1.0) < 1e-5


def test_both_are_about_the_same_plant_with_its_bands(told):
    """Estimates with both ends of their intervals beside the truth; residuals with deviations."""
    for p in ('p1', 'p2', 'p3'):
        values = {path['value'].split('.')[0] + '.' + path['value'].split('.')[1].split('[')[0]
                  for path in PANELS[f'Plot!{p}']['paths']}  # fmt: skip
        assert values == {
            '/estimator/parameters.position', '/estimator/parameters_interval.position',
            '/estimator/parameters_interval.velocity', '/plant/parameters.position',
        }  # fmt: skip
    factors = [PATH.fullmatch(path['value'])[5] for path in PANELS['Plot!residual']['paths']]
    assert factors == [None, '2', '-2', None, '2', '-2']
