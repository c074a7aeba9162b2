"""The layout for PlotJuggler names what the nodes publish on the three tanks."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from obs_ros import load_model
from obs_ros.interface.vectors import TOPICS

LAYOUT = ET.parse(Path(__file__).parents[2] / 'docs' / 'plotjuggler.xml').getroot()


def test_every_curve_is_published():
    known = {variable.name for variable in load_model('three_tank').variables}
    curves = [curve.get('name') for curve in LAYOUT.iter('curve')]
    assert len(curves) == 18
    for curve in curves:
        # As PlotJuggler calls the entries of a JointState.
        topic, name, figure = re.fullmatch(r'/estimator/(\w+)/(\w+)/(\w+)', curve).groups()
        assert topic in TOPICS and name in known
        figures = ('position', 'velocity') if topic == 'parameters_interval' else ('position',)
        assert figure in figures


def test_splitters_hold_as_many_areas_as_they_say():
    tabs = LAYOUT.findall('tabbed_widget/Tab')
    assert [tab.get('tab_name') for tab in tabs] == ['parameters', 'states', 'standard deviations']
    for splitter in LAYOUT.iter('DockSplitter'):
        sizes = [float(size) for size in splitter.get('sizes').split(';')]
        assert len(sizes) == int(splitter.get('count')) == len(splitter.findall('DockArea'))
        assert abs(sum(sizes) - 1.0) < 1e-5
