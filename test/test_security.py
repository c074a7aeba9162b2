"""Nobody but whoever starts a node decides what code runs in it."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted(f for package in ('obs_ros', 'plant_sim') for f in (ROOT / package).rglob('*.py'))
CALLS = {'eval', 'exec', 'compile', '__import__', 'execfile'}
MODULES = {'pickle', 'cPickle', 'dill', 'cloudpickle', 'joblib', 'marshal', 'shelve', 'subprocess'}
# Of os, numpy and yaml: shells, and readers that may build any object.
ATTRIBUTES = {
    'system', 'popen', 'execv', 'execvp', 'spawnv', 'unsafe_load', 'full_load', 'UnsafeLoader',
    'FullLoader', 'allow_pickle',
}  # fmt: skip
ALLOWED = {
    # Kernels are code, made here and kept in a folder of the user's own: docs/security.md.
    'obs_ros/core/kernel_cache.py': {'pickle'},
    # Python starts itself anew, without a shell, to compile the model it has: docs/security.md.
    'obs_ros/interface/compilation.py': {'subprocess'},
    # The operations that a plant's function came to, as numbers and names of our own.
    'obs_ros/core/tracing.py': {'exec', 'compile'},
    'obs_ros/integration/kernel_modules.py': {'exec', 'compile'},
    # A Dask worker runs what its client sends: docs/security.md.
    'obs_ros/studies/worker.py': {'pickle'},
}


def forbidden(text):
    """What evaluates, unpickles or calls a shell, with its line."""
    for node in ast.walk(ast.parse(text)):
        found = None
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found = node.func.id if node.func.id in CALLS else None
        elif isinstance(node, ast.Attribute):
            plain = isinstance(node.value, ast.Name)
            is_yaml_load = plain and node.value.id == 'yaml' and node.attr == 'load'
            found = node.attr if node.attr in ATTRIBUTES or is_yaml_load else None
        elif isinstance(node, ast.keyword):
            denied = isinstance(node.value, ast.Constant) and node.value.value is False
            found = node.arg if node.arg in ATTRIBUTES and not denied else None
        elif isinstance(node, ast.Import):
            found = next((a.name for a in node.names if a.name.split('.')[0] in MODULES), None)
        elif isinstance(node, ast.ImportFrom):
            found = node.module if (node.module or '').split('.')[0] in MODULES else None
        if found:
            yield f'{found} in line {node.lineno}'


@pytest.mark.parametrize('file', SOURCES, ids=lambda file: str(file.relative_to(ROOT)))
def test_nothing_is_evaluated_or_unpickled(file):
    found = {words.split()[0] for words in forbidden(file.read_text())}
    assert found == ALLOWED.get(str(file.relative_to(ROOT)), set())


@pytest.mark.parametrize(
    'text',
    ['eval("1")', 'exec(x)', 'import pickle', 'from pickle import loads', 'import os.path, marshal',
     'os.system("ls")', 'np.load(f, allow_pickle=True)', 'yaml.load(f)', 'yaml.unsafe_load(f)'],
)  # fmt: skip
def test_the_search_finds_what_it_is_for(text):
    assert list(forbidden(text))


@pytest.fixture
def planted(tmp_path, monkeypatch):
    """A module that leaves a file behind when it is imported."""
    trace = tmp_path / 'imported'
    (tmp_path / 'planted').mkdir()
    for name in ('__init__', 'msg', 'code'):
        text = f'import pathlib\npathlib.Path({str(trace)!r}).touch()\n'
        (tmp_path / 'planted' / f'{name}.py').write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    return trace


ATTEMPTS = [
    ('model', 'planted.code:MODEL'),
    ('observer', 'planted.code:Observer'),
    ('signals.h1.topic', '/planted'),
    ('signals.h1.type', 'planted/msg/Type'),
    ('signals.h1.field', 'planted'),
    ('signals.Q1.stamp', 'arrival'),
    ('signals.h9.type', 'planted/msg/Type'),
    ('merge_wait', 5.0),
]


@pytest.mark.parametrize(('name', 'value'), ATTEMPTS, ids=[name for name, _ in ATTEMPTS])
def test_no_remote_caller_makes_the_estimator_import(ros, planted, name, value):
    """Through the services, as `ros2 param set` does."""
    from rcl_interfaces.srv import SetParameters, SetParametersAtomically
    from rclpy.parameter import Parameter

    from obs_ros.ros.estimator import Estimator

    node = ros.start(Estimator, observer='node.fakes:FakeObserver')
    before = {k: v.value for k, v in node.get_parameters_by_prefix('').items()}
    change = [Parameter(name, value=value).to_parameter_msg()]
    for kind, service in (
        (SetParameters, 'set_parameters'),
        (SetParametersAtomically, 'set_parameters_atomically'),
    ):
        answer = ros.call(f'/estimator/{service}', kind, parameters=change)
        result = answer.results[0] if kind is SetParameters else answer.result
        assert not result.successful and result.reason
    assert not planted.exists()
    assert {k: str(v.value) for k, v in node.get_parameters_by_prefix('').items()} == {
        k: str(v) for k, v in before.items()
    }


@pytest.mark.parametrize(('name', 'value'), ATTEMPTS[:6], ids=[name for name, _ in ATTEMPTS[:6]])
def test_nor_a_managed_one_before_it_is_configured(ros, planted, name, value):
    """Structure may be mended there; what names code is refused, or configure fails without it."""
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    from obs_ros.ros.estimator import Estimator

    code = ('model', 'observer', 'signals.h1.type')
    given = {'signals__h1__topic': '', 'signals__h1__type': '', 'signals__h1__field': '',
             'signals__Q1__stamp': 'header'}  # fmt: skip
    ros.start(Estimator, managed=True, **given)
    change = [Parameter(name, value=value).to_parameter_msg()]
    answer = ros.call('/estimator/set_parameters', SetParameters, parameters=change).results[0]
    assert answer.successful == (name not in code), answer.reason
    configure = Transition(label='configure')
    configured = ros.call('/estimator/change_state', ChangeState, transition=configure).success
    assert configured == (name in code), 'a binding that is half given is refused'
    assert not planted.exists()


def test_no_remote_caller_makes_the_simulator_import(ros, planted):
    from ros import set_parameter

    from plant_sim.node import Simulator

    node = ros.start(Simulator, enabled=False)
    assert not set_parameter(node, 'scenario', 'planted.code:SCENARIO').successful
    assert not planted.exists() and node.get_parameter('scenario').value == 'three_tank'
