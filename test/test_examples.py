"""The shipped example and its tutorial: a package that others could install, and that estimates."""

import re
from pathlib import Path

import numpy as np
import pytest
from catkin_pkg.package import parse_package
from scipy.integrate import solve_ivp

from obs_ros import Outcome, load_model

ROOT = Path(__file__).resolve().parents[1]
EXAMPLE = ROOT / 'examples' / 'my_plant'
TUTORIAL = (ROOT / 'docs' / 'your-own-plant.md').read_text()
NAME = 'my_plant.pendulum:PENDULUM'
PARAMETERS = EXAMPLE / 'config' / 'pendulum.yaml'
SCENARIO = 'my_plant.scenario:SWINGS'
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


@pytest.mark.parametrize(
    'file', ['my_plant/pendulum.py', 'my_plant/heater.py', 'config/pendulum.yaml']
)
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

    from obs_ros.ros.estimator import Estimator
    from obs_ros.ros.messages import STREAM, named_vector, time_message

    monkeypatch.setenv('OBS_ROS_BACKEND', 'numpy')  # nothing to compile for one window
    estimator = ros.start(
        Estimator, '--ros-args', '--params-file', str(PARAMETERS), use_sim_time=True, deadline=60.0
    )
    assert estimator.estimation.model is load_model(NAME)
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
    angles = swing(t, torque) + 0.01 * np.random.default_rng(2).standard_normal(t.size)
    inputs = estimator.estimation.streams.subscriptions['input./drive/torque']
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
    ros.spin_until(lambda: found and deviations, timeout=30.0)
    values, sd = vector(found[0]), vector(deviations[0])
    for name, true in TRUTH.items():
        assert 0.0 < sd[name] < 0.05
        assert abs(values[name] - true) < 3.0 * sd[name], name


def test_the_simulator_plays_the_scenario_on_the_bindings_as_the_rig_would(ros):
    """Sample by sample what a run offline gives, in the rig's units, and only there."""
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64
    from std_srvs.srv import SetBool

    from plant_sim.node import Simulator
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    ros.start(
        Simulator, '--ros-args', '--params-file', str(PARAMETERS), enabled=False, publish_clock=True
    )
    encoder = ros.listen('/joint_states', JointState)
    drive = ros.listen('/drive/torque', Float64)
    states = ros.listen('/plant/state')
    assert ros.call('/simulator/enable', SetBool, data=True).success
    ros.spin_until(lambda: min(map(len, (encoder, drive, states))) >= 60)
    assert not ros.node.count_publishers('/plant/output')
    assert not ros.node.count_publishers('/plant/input')
    run = Simulation(load_scenario(SCENARIO))
    for k in range(60):
        instant = run.sample()
        stamp = encoder[k].header.stamp
        assert stamp.sec + 1e-9 * stamp.nanosec == pytest.approx(instant.t)
        assert (encoder[k].name, list(encoder[k].position)) == (['pendulum'], list(instant.y))
        assert 20.0 * drive[k].data == pytest.approx(instant.u[0])
        assert tuple(states[k].position) == instant.x


def test_a_wrong_binding_of_the_simulator_is_refused_as_the_estimators_is(ros):
    from plant_sim.node import Simulator

    with pytest.raises(ValueError, match=r"signals\.torque\.field: .* has no field 'value'"):
        ros.start(
            Simulator,
            '--ros-args',
            '--params-file',
            str(PARAMETERS),
            signals__torque__field='value',
        )


def test_the_tutorial_goes_from_its_files_to_estimates(ros):
    """Both nodes with the file as it is: the estimator's own word, while it waits and after."""
    from diagnostic_msgs.msg import DiagnosticArray
    from ros import figures, vector

    from obs_ros.core.estimate import Outcome
    from obs_ros.ros.estimator import Estimator
    from plant_sim.node import Simulator

    file = ('--ros-args', '--params-file', str(PARAMETERS))
    estimator = ros.start(Estimator, *file)
    told, found = ros.listen('/diagnostics', DiagnosticArray), ros.listen('/estimator/parameters')
    ros.spin_until(lambda: estimator.estimation.progress.ready, timeout=30.0)
    ros.start(Simulator, *file)

    def outcomes():
        statuses = [array.status[0] for array in told if array.status[0].name == '/estimator']
        return {figures(status)['outcome'] for status in statuses}

    ros.spin_until(lambda: found and outcomes() & set(Outcome), timeout=30.0)
    assert 'collecting' in outcomes() and not estimator.estimation.progress.failed
    assert vector(found[0]).keys() == TRUTH.keys()


def test_the_scenario_tells_what_is_sought_and_shows_the_weight_that_slips():
    """Offline, so that no arrival is late: values within 3 sd, and one jump, of stiffness."""
    from obs_ros.core.record import Sample
    from obs_ros.interface.settings import build_observer
    from obs_ros.replay.parameter_file import read_parameters
    from obs_ros.replay.settings import setup
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    chosen = setup(read_parameters(PARAMETERS))
    observer = build_observer(chosen.model, chosen.values)
    run, scenario = Simulation(load_scenario(SCENARIO)), load_scenario(SCENARIO)
    jumps, confirmed = [], 0
    for _ in range(round(45.0 / scenario.sample_period)):
        instant = run.sample()
        stamp = round(instant.t * 1e9)
        observer.absorb(Sample(stamp, u=np.array(instant.u)))
        if not observer.absorb(Sample(stamp, y=np.array(instant.y))):
            continue
        estimate = observer.estimate()
        jumps += [jump for jump in estimate.jumps if jump.new]
        if estimate.outcome == 'converged':
            confirmed += 1
        # A jump shows when the pendulum has swung on for a period, of 2.5 s.
        if estimate.outcome == 'converged' and not 30.0 < instant.t < 32.5:
            for name, true in zip(TRUTH, scenario.parameters(instant.t - 1e-6)):
                assert abs(estimate.parameters[name] - true) < 4.0 * estimate.stddev[name]
    assert confirmed >= 36  # of 42
    assert [set(jump.sizes) for jump in jumps] == [{'stiffness'}]
    assert abs(jumps[0].sizes['stiffness'] + 1.5) < 3.0 * jumps[0].stddev['stiffness'] < 3.0
    assert jumps[0].stamp / 1e9 == pytest.approx(30.0, abs=0.5)


def test_the_heater_is_estimated_at_its_nodes():
    from obs_ros import Record, solve_window
    from plant_sim.scenarios import load_scenario
    from plant_sim.simulation import Simulation

    plant = Simulation(load_scenario('my_plant.scenario:BAKES'), seed=1)
    rows = [plant.sample() for _ in range(100)]
    record = Record(*(np.array([getattr(row, name) for row in rows]) for name in 'tuy'))
    found = solve_window('my_plant.heater:HEATER', record, seed=1, noise={'warm': 0.1})
    assert found.outcome is Outcome.CONVERGED
    for name, true in {'keep': 0.95, 'gain': 0.05}.items():
        assert abs(found.parameters[name] - true) < 3.0 * found.stddev[name] < 0.03 * true, name
