"""The shipped example and its tutorial: a package that others could install, and that estimates."""

import re
from pathlib import Path

import numpy as np
import pytest
from catkin_pkg.package import parse_package
from scipy.integrate import solve_ivp

from obs_ros import load_model

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / 'examples' / 'my_plant'
TUTORIAL = (ROOT / 'docs' / 'your-own-plant.md').read_text()
NAME = 'my_plant.pendulum:PENDULUM'
PARAMETERS = EXAMPLE / 'config' / 'pendulum.yaml'
TRUTH = {'stiffness': 8.0, 'friction': 0.3}


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """As `source install/setup.bash` does, for this test."""
    monkeypatch.syspath_prepend(EXAMPLE)


def test_the_package_is_one():
    manifest = parse_package(EXAMPLE / 'package.xml')
    manifest.validate()
    setup = (EXAMPLE / 'setup.py').read_text()
    assert manifest.get_build_type() == 'ament_python'
    assert f"package_name = '{manifest.name}'" in setup
    assert f"version='{manifest.version}'" in setup
    assert (EXAMPLE / 'resource' / manifest.name).is_file()
    assert 'obs_ros' in {dependency.name for dependency in manifest.exec_depends}
    for file in re.findall(r"\['([^']+)'\]", setup):
        assert (EXAMPLE / file.replace('{package_name}', manifest.name)).is_file()


def test_colcon_never_meets_it_inside_of_obs_ros():
    """It looks no further below a package; a COLCON_IGNORE would be copied along with examples."""
    assert (ROOT / 'package.xml').is_file()
    assert not list((ROOT / 'examples').rglob('COLCON_IGNORE'))


@pytest.mark.parametrize('file', ['my_plant/pendulum.py', 'config/pendulum.yaml'])
def test_the_tutorial_shows_the_files_as_they_are(file):
    text = (EXAMPLE / file).read_text()
    assert ''.join(f'    {line}\n' if line else '\n' for line in text.splitlines()) in TUTORIAL


def test_every_file_that_the_tutorial_links_is_there():
    links = re.findall(r']\(([^)#]+)\)', TUTORIAL)
    assert len(links) >= 2
    for link in links:
        assert (ROOT / 'docs' / link).exists(), link


def swing(t, torque):
    """Angles (K,) at times t (K,) in s under a torque held from each whole half second on."""

    def rates(_, x, u):
        return x[1], u - TRUTH['stiffness'] * np.sin(x[0]) - TRUTH['friction'] * x[1]

    angles, x = [], np.array([0.4, 0.0])
    for k, u in enumerate(torque):
        inside = t[(t >= 0.5 * k - 1e-9) & (t < 0.5 * (k + 1) - 1e-9)]
        solution = solve_ivp(
            rates, (0.5 * k, 0.5 * (k + 1)), x, args=(u,), t_eval=[*inside, 0.5 * (k + 1)],
            rtol=1e-9, atol=1e-9,
        )  # fmt: skip
        angles.extend(solution.y[0, :-1])
        x = solution.y[:, -1]
    return np.array(angles)


def test_the_example_estimates_from_the_messages_of_its_bindings(ros, monkeypatch):
    """The encoder's angle with noise, the drive's torque in N m and without a stamp."""
    from ros import vector
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64

    from obs_ros.node.estimator import Estimator
    from obs_ros.node.messages import STREAM, named_vector, time_message

    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')  # nothing to compile for one window
    estimator = ros.start(
        Estimator, '--ros-args', '--params-file', str(PARAMETERS), use_sim_time=True, deadline=60.0
    )
    assert estimator.model is load_model(NAME)
    found = ros.listen('/estimator/parameters')
    deviations = ros.listen('/estimator/parameters_stddev')
    publishers = [
        ros.node.create_publisher(kind, topic, STREAM)
        for kind, topic in (
            (Clock, '/clock'), (JointState, '/joint_states'), (Float64, '/drive/torque'),
        )
    ]  # fmt: skip
    for publisher in publishers:
        ros.spin_until(publisher.get_subscription_count)
    clock, encoder, drive = (publisher.publish for publisher in publishers)

    t, start = 0.02 * np.arange(225), 1000.0
    torque = np.random.default_rng(1).uniform(-3.0, 3.0, 9)
    angles = swing(t, torque) + 0.002 * np.random.default_rng(2).standard_normal(t.size)
    inputs = estimator._feeds['input./drive/torque']
    for k, u in enumerate(torque):
        stamp = round((start + 0.5 * k) * 1e9)
        clock(Clock(clock=time_message(stamp)))
        ros.spin_until(lambda s=stamp: estimator.get_clock().now().nanoseconds == s)
        drive(Float64(data=0.05 * u))
        ros.spin_until(lambda k=k: inputs.received == k + 1)
        for i in range(25 * k, 25 * (k + 1)):
            stamp = round((start + t[i]) * 1e9)
            encoder(named_vector(stamp, ['wheel', 'pendulum'], [9.0, angles[i]]))
    clock(Clock(clock=time_message(round((start + 4.5) * 1e9))))
    ros.spin_until(lambda: found and deviations, timeout=60.0)
    values, sd = vector(found[0]), vector(deviations[0])
    for name, true in TRUTH.items():
        assert 0.0 < sd[name] < 0.01
        assert abs(values[name] - true) < 3.0 * sd[name], name
