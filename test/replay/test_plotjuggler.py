"""The layout for PlotJuggler names what the nodes publish on the three tanks."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from obs_ros import load_model
from obs_ros.interface.vectors import TOPICS

LAYOUT = ET.parse(Path(__file__).parents[2] / 'docs' / 'plotjuggler.xml').getroot()


def test_every_curve_is_published_or_computed_from_what_is():
    known = {variable.name for variable in load_model('three_tank').variables}

    def published(curve):
        # As PlotJuggler calls the entries of a JointState.
        match = re.fullmatch(r'/estimator/(\w+)/(\w+)/position', curve or '')
        return match is not None and match[1] in TOPICS and match[2] in known

    computed = set()
    for snippet in LAYOUT.iter('snippet'):
        sources = [snippet.find('linked_source'), *snippet.find('additional_sources')]
        assert all(published(source.text) for source in sources)
        computed.add(snippet.get('name'))
    curves = [curve.get('name') for curve in LAYOUT.iter('curve')]
    assert len(curves) == 18
    assert all(published(curve) or curve in computed for curve in curves)
    assert computed <= set(curves)


def test_splitters_hold_as_many_areas_as_they_say():
    tabs = LAYOUT.findall('tabbed_widget/Tab')
    assert [tab.get('tab_name') for tab in tabs] == ['parameters', 'states', 'standard deviations']
    for splitter in LAYOUT.iter('DockSplitter'):
        sizes = [float(size) for size in splitter.get('sizes').split(';')]
        assert len(sizes) == int(splitter.get('count')) == len(splitter.findall('DockArea'))
        assert abs(sum(sizes) - 1.0) < 1e-5
