"""Fast DDS with little memory for each topic."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from patience import patience

from demo.domain import Domain
from obs_ros.ros.lean_middleware import lean_middleware

NAMES = ('RMW_FASTRTPS_USE_QOS_FROM_XML', 'FASTRTPS_DEFAULT_PROFILES_FILE')
TOPICS = 100

# Prints KB of resident memory for each reader, and what it has heard at last.
READERS = f"""
import contextlib, sys, time
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Int64
from obs_ros.ros.lean_middleware import lean_middleware

def resident():
    return int(next(line for line in open('/proc/self/status') if 'VmRSS' in line).split()[1])

rclpy.init()
with lean_middleware() if sys.argv[1] == 'lean' else contextlib.nullcontext():
    node = Node('readers')
heard, deep = [], QoSProfile(depth=5000)
subscription = node.create_subscription(Int64, 'one', lambda m: heard.append(m.data), deep)
publisher = node.create_publisher(Int64, 'one', deep)
before = resident()
for k in range({TOPICS}):
    node.create_subscription(Int64, f'topic_{{k}}', heard.append, deep)
print((resident() - before) / {TOPICS})
while not publisher.get_subscription_count():
    time.sleep(0.01)
for k in range(3000):
    publisher.publish(Int64(data=k))
while len(heard) < 3000:
    rclpy.spin_once(node, timeout_sec=0.1)
assert heard == list(range(3000))
"""


@pytest.mark.slow
def test_a_reader_takes_less_than_half_the_memory_and_loses_nothing():
    kilobytes = {}
    with Domain() as domain:
        environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain),
                       'PYTHONPATH': os.pathsep.join(sys.path)}  # fmt: skip
        for way in ('lean', 'usual'):
            ended = subprocess.run(
                [sys.executable, '-c', READERS, way], env=environment, capture_output=True,
                text=True, timeout=patience(30.0), check=False,
            )  # fmt: skip
            assert ended.returncode == 0 and 'XMLPARSER' not in ended.stderr, ended.stderr
            kilobytes[way] = float(ended.stdout)
    assert kilobytes['lean'] < 0.5 * kilobytes['usual'] < 100.0


def test_nothing_of_it_is_left(monkeypatch):
    for name in NAMES:
        monkeypatch.delenv(name, raising=False)
    with lean_middleware():
        file = Path(os.environ[NAMES[1]])
        assert file.read_text().count('<allocated_samples>1<') == 2
        assert os.environ[NAMES[0]] == '1'
    assert not file.exists() and not {*NAMES} & {*os.environ}


@pytest.mark.parametrize('name', [*NAMES, 'FASTDDS_DEFAULT_PROFILES_FILE'])
def test_whoever_has_settings_of_fast_dds_keeps_them(monkeypatch, name):
    for other in NAMES:
        monkeypatch.delenv(other, raising=False)
    monkeypatch.setenv(name, 'mine')
    before = dict(os.environ)
    with lean_middleware():
        assert dict(os.environ) == before
