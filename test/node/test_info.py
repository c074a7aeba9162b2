"""~/info tells model and settings as YAML."""

from dataclasses import replace

import yaml
from ros import Ros
from std_msgs.msg import String

from obs_ros.core.prior_knowledge import with_knowledge
from obs_ros.models import load_model
from obs_ros.ros.info import model_info, publish_info, settings_info
from obs_ros.ros.messages import LATCHED


def test_who_comes_late_reads_it_too(ros: Ros):
    publish = publish_info(ros.node)
    publish({**model_info(load_model('three_tank')), **settings_info({'a.b': (1.0, 2.0)})})
    texts = ros.listen('/test/info', String, LATCHED)
    info = yaml.safe_load(ros.spin_until(lambda: texts)[0].data)
    assert info['model'] == 'three_tank' and info['settings'] == {'a.b': [1.0, 2.0]}
    assert info['inputs'][0]['name'] == 'Q1'


def test_info_tells_what_is_on_a_log_scale():
    found = model_info(load_model('heat_exchanger_reduced'))
    assert found['parameters'][0] == {
        'name': 'dP1', 'unit': 'Pa', 'bounds': [1.0e5, 1.0e6], 'scale': 'log'
    }  # fmt: skip
    assert 'scale' not in found['states'][0]


def test_info_tells_what_is_known_beforehand():
    known = with_knowledge(load_model('three_tank'), {'h1': 0.2}, {'p1': (0.5, 0.1)})
    found = model_info(known)
    assert found['states'][0] == {
        'name': 'h1', 'unit': 'cm', 'bounds': [0.0, 100.0], 'walk': 0.2
    }  # fmt: skip
    assert found['parameters'][0]['prior'] == [0.5, 0.1]
    assert not {'walk', 'prior'} & set(found['states'][1])


def test_info_tells_what_sensors_and_actuators_do():
    tanks = load_model('three_tank')
    level = replace(tanks.outputs[0], resolution=0.5, range=(0.0, 60.0), delay=2.0)
    found = model_info(replace(tanks, outputs=(level, tanks.outputs[1])))['outputs']
    assert found[0]['delay'] == 2.0 and found[0]['resolution'] == 0.5
    assert found[0]['range'] == [0.0, 60.0] and set(found[1]) == {'name', 'unit', 'bounds'}
