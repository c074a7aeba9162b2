"""A newcomer's terminals: commands of the documents, translated to what this machine has of ROS."""

import argparse
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import get_package_prefix
from documents import ROOT, Command
from patience import patience
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros import Ros
from std_msgs.msg import String

from obs_ros.interface.vectors import TOPICS
from obs_ros.ros.messages import LATCHED

NODES = ('estimator', 'fleet', 'simulator')
TROUBLE = ('Traceback', '[ERROR]', '[FATAL]')  # in the words of a node that ends in peace
Action = Callable[['Session', list[str]], None]


class UntranslatableError(Exception):
    """A command that nothing here stands for; the message says where to teach it."""


class Session:
    """Terminals side by side in one ROS domain; `files` are what RECORDING and FILE stand for."""

    def __init__(self, ros: Ros, folder: Path, files: dict[str, str]) -> None:
        self.ros, self.folder, self.files = ros, folder, files
        self.environment = {
            **os.environ, 'ROS_DOMAIN_ID': str(ros.context.get_domain_id()), 'MAKEFLAGS': '',
        }  # fmt: skip
        self.nodes: dict[str, subprocess.Popen[bytes]] = {}
        self._lines: dict[str, list[str]] = {}  # that started them
        self._echoes: dict[str, list[Any]] = {}

    def perform(self, block: Sequence[Command]) -> None:
        """Do what stands in one block; every `echo` of it must have printed something at its end.

        Raises AssertionError where a command fails, UntranslatableError where one is new.
        """
        for command in block:
            action, condition = translation(command), awaited(command)
            condition(self)
            action(self, [self._filled(word) for word in command.words])
        for topic, messages in self._echoes.items():
            self._wait_for(topic, messages)
        self._echoes.clear()
        assert not self._ended(), self._ended()

    def _wait_for(self, topic: str, messages: list[Any]) -> None:
        """Wait for a message; where the machine was too busy for it, start the plant again."""
        for _ in range(3):
            with suppress(AssertionError):
                self.ros.spin_until(lambda: messages or self._ended(), timeout=30.0)
                return
            for name in [each for each in self.nodes if each.endswith('/simulator')]:
                self.run(self._lines[name])
        told = {name: self._told(name)[-2000:] for name in self.nodes}
        raise AssertionError(f'nothing came on {topic}; the nodes said {told}')

    def close(self) -> None:
        """End every node as Ctrl-C does: at once, with exit code 0 and no word of trouble."""
        for name in tuple(self.nodes):
            self._end(name)

    def kill(self) -> None:
        """End what a failure has left."""
        for process in self.nodes.values():
            process.kill()
            process.wait()

    def run(self, words: list[str]) -> None:
        """`ros2 run obs_ros NAME ...`: nodes go on in the background, all else to its end."""
        name, arguments = words[3], words[4:]
        path = Path(get_package_prefix('obs_ros')) / 'lib' / 'obs_ros' / name
        assert os.access(path, os.X_OK), f'`ros2 run obs_ros {name}` would not find {path}'
        if name not in NODES:
            self._foreground([str(path), *arguments])
            return
        spaces = [w.removeprefix('__ns:=') for w in arguments if w.startswith('__ns:=')]
        name = f'{"".join(spaces)}/{name}'
        if name in self.nodes:  # whoever reads on ends the one before
            self._end(name)
        self._lines[name] = words
        with self._words(name).open('wb') as words_of_it:
            self.nodes[name] = subprocess.Popen(
                [path, *arguments], cwd=self.folder, env=self.environment,
                stdout=words_of_it, stderr=words_of_it, start_new_session=True,
            )  # fmt: skip
        told = self.ros.listen(f'{name}/info', String, LATCHED)
        self.ros.spin_until(lambda: told or self._ended(), timeout=30.0)
        if name.endswith('/estimator'):  # what comes once must not come before it is compiled
            self.ros.spin_until(lambda: 'ready' in self._told(name) or self._ended(), timeout=60.0)

    def python(self, words: list[str]) -> None:
        """`python -m MODULE ...`."""
        self._foreground([sys.executable, *words[1:]])

    def echo(self, words: list[str]) -> None:
        """`ros2 topic echo`: prints what comes from now on, or is there already if latched."""
        parser = argparse.ArgumentParser()
        for flag in ('--once', '--full-length'):
            parser.add_argument(flag, action='store_true')
        parser.add_argument('--field')
        parser.add_argument('topic')
        parser.add_argument('type', nargs='?')
        options = parser.parse_args(words[3:])
        self._have_nodes()
        node = self.ros.node
        known = self.ros.spin_until(
            lambda: dict(node.get_topic_names_and_types()).get(options.topic), timeout=30.0
        )
        assert options.type in (None, *known)
        kind = _class(known[0])
        assert not options.field or hasattr(kind(), options.field)
        offered = [info.qos_profile for info in node.get_publishers_info_by_topic(options.topic)]
        latched = all(qos.durability == DurabilityPolicy.TRANSIENT_LOCAL for qos in offered)
        reliable = all(qos.reliability == ReliabilityPolicy.RELIABLE for qos in offered)
        qos = QoSProfile(
            depth=10,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        )
        self._echoes[options.topic] = self.ros.listen(options.topic, kind, qos)

    def set_parameter(self, words: list[str]) -> None:
        """`ros2 param set NODE NAME VALUE`."""
        node, name, value = words[3:]
        self._have_nodes()
        parameter = Parameter(name=name, value=get_parameter_value(value))
        (answer,) = self.ros.call(
            f'{node}/set_parameters', SetParameters, parameters=[parameter]
        ).results
        assert answer.successful, answer.reason

    def get_parameter(self, words: list[str]) -> None:
        """`ros2 param get NODE NAME`."""
        node, name = words[3:]
        self._have_nodes()
        (value,) = self.ros.call(f'{node}/get_parameters', GetParameters, names=[name]).values
        assert parameter_value_to_python(value) is not None, f'{node} has no parameter {name}'

    def dump_parameters(self, words: list[str]) -> None:
        """`ros2 param dump NODE`, which sorts names into mappings at their dots."""
        (node,) = words[3:]
        self._have_nodes()
        names = self.ros.call(f'{node}/list_parameters', ListParameters).result.names
        assert names
        for name in names:
            assert not any(other.startswith(f'{name}.') for other in names), name
        values = self.ros.call(f'{node}/get_parameters', GetParameters, names=names).values
        assert all(parameter_value_to_python(value) is not None for value in values)

    def call(self, words: list[str]) -> None:
        """`ros2 service call NAME TYPE [FIELDS]`."""
        name, kind, *fields = words[3:]
        self._have_nodes()
        given = yaml.safe_load(fields[0]) if fields else {}
        answer = self.ros.call(name, _class(kind), **given)
        assert getattr(answer, 'success', True), answer

    def first_window(self) -> None:
        """Wait until a window has closed, of those that begin from now on."""
        estimates = self.ros.listen('/estimator/state')
        self.ros.spin_until(lambda: estimates, timeout=60.0)

    def _have_nodes(self) -> None:
        """Start what the README starts first, where a page takes it for running."""
        if not self.nodes:
            self.run(['ros2', 'run', 'obs_ros', 'estimator'])
            self.run(['ros2', 'run', 'obs_ros', 'simulator', '--ros-args', '-p', 'speed:=100.0'])

    def _foreground(self, line: list[str]) -> None:
        done = subprocess.run(
            line, cwd=self.folder, env=self.environment, capture_output=True, text=True,
            timeout=patience(60.0), check=False,
        )  # fmt: skip
        assert done.returncode == 0 and done.stdout.strip(), done.stderr

    def _end(self, name: str) -> None:
        process = self.nodes[name]
        process.send_signal(signal.SIGINT)
        code = process.wait(patience(10.0))
        del self.nodes[name]
        told = self._told(name)
        assert code == 0 and not any(word in told for word in TROUBLE), told

    def _ended(self) -> list[str]:
        """Return the words of nodes that have ended by themselves."""
        return [self._told(n) for n, process in self.nodes.items() if process.poll() is not None]

    def _told(self, name: str) -> str:
        return self._words(name).read_text(errors='replace')

    def _words(self, name: str) -> Path:
        """Return the file of what a node says."""
        return self.folder / name.strip('/').replace('/', '_')

    def _filled(self, word: str) -> str:
        """Put in what stands for something: other files, and the prefix of a package."""
        word = re.sub(r'\{prefix:(\w+)\}', lambda match: get_package_prefix(match[1]), word)
        for name, path in self.files.items():
            word = re.sub(rf'\b{name}(?=$|_)', path, word)
        return word


def translation(command: Command) -> Action:
    """Return what is done for a command; raises UntranslatableError where nothing is known."""
    line = re.sub(r'^(python -m benchmarks)\.\w+', r'\1', ' '.join(command.words)).split()
    for length in range(len(line), 0, -1):
        if found := TRANSLATIONS.get(' '.join(line[:length])):
            return found
    raise UntranslatableError(
        f'{command} is documented, but never tried: tell TRANSLATIONS in {Path(__file__).name} how'
    )


def awaited(command: Command) -> Callable[[Session], None]:
    """Return what the comment beside a command waits for; raises UntranslatableError."""
    if not command.comment.startswith('once '):
        return lambda session: None
    if command.comment not in CONDITIONS:
        raise UntranslatableError(f'{command}: nothing is known of "{command.comment}"')
    return CONDITIONS[command.comment]


def _class(name: str) -> Any:
    package, kind, type_name = name.split('/')
    return getattr(import_module(f'{package}.{kind}'), type_name)


def _covered(reason: str) -> Action:
    """Stand for what cannot run here, and why; or what other tests run."""
    assert reason
    return lambda session, words: None


def _make(session: Session, words: list[str]) -> None:
    """Let `make` look for the target; demo, test and check run by themselves, help runs here."""
    dry = [] if words[1:] == ['help'] else ['-n']
    done = subprocess.run(
        ['make', *dry, *words[1:]], cwd=ROOT, env=session.environment, capture_output=True,
        text=True, timeout=patience(10.0), check=False,
    )  # fmt: skip
    assert done.returncode == 0 and done.stdout, done.stderr


def _pip_install(session: Session, words: list[str]) -> None:
    """See that the package is one that set-up installs, or the extra one of setup.py."""
    pinned = (ROOT / 'requirements' / 'pins.txt').read_text().lower()
    extras = (ROOT / 'setup.py').read_text()
    for word in words[2:]:
        if match := re.fullmatch(r'\.\[(\w+)\]', word):
            assert f"'{match[1]}': [" in extras, word
        else:
            assert re.search(rf'^{re.escape(word)}==', pinned, re.MULTILINE), word


def _colcon_build(session: Session, words: list[str]) -> None:
    """See that the packages are there: colcon itself is not among the wheels."""
    assert words[2] == '--packages-select'
    named = '\n'.join(file.read_text() for file in ROOT.glob('**/package.xml'))
    assert all(f'<name>{package}</name>' in named for package in words[3:])


def _benchmark(session: Session, words: list[str]) -> None:
    """See that the module is there: benchmarks take minutes to hours."""
    assert list(ROOT.glob(f'{words[2].replace(".", "/")}*')), words[2]


def _export(session: Session, words: list[str]) -> None:
    """Set variables, but for those of SROS2, which is not among the wheels."""
    for name, _, value in (word.partition('=') for word in words[1:]):
        if not name.startswith('ROS_SECURITY'):
            session.environment[name] = value


def _replay(session: Session, words: list[str]) -> None:
    """Replay once more where an earlier line has: `--force`, which its refusal names."""
    there = Path(f'{session.files["RECORDING"]}_replay').exists()
    line = [*words, '--force'] if there else words
    (session.run if words[0] == 'ros2' else session.python)(line)


def _play(session: Session, words: list[str]) -> None:
    """See that there is what the page above has written: `ros2 bag` is not among the wheels."""
    if not Path(words[3]).exists():
        _replay(session, ['ros2', 'run', 'obs_ros', 'replay', *session.files['REPLAY'].split()])
    assert (Path(words[3]) / 'metadata.yaml').exists()


def _plot(session: Session, words: list[str]) -> None:
    """See that the topics of the curves are published: rqt is not among the wheels."""
    for curve in words[4:]:
        assert curve.split('/')[2] in TOPICS, curve


def _layout(session: Session, words: list[str]) -> None:
    """See that the layout is installed: PlotJuggler is not among the wheels."""
    assert words[4] == '--layout' and Path(words[5]).is_file(), words[5]


CONDITIONS = {'once the first window is full': Session.first_window}
TRANSLATIONS: dict[str, Action] = {
    'make': _make,
    'cd': _covered('paths of the reader'),
    'git clone': _covered('the reader has done so'),
    'colcon build': _colcon_build,
    'source install/setup.bash': _covered('AMENT_PREFIX_PATH names the prefixes here'),
    'export': _export,
    'pip install': _pip_install,
    'python -m benchmarks': _benchmark,
    'python -m obs_ros.replay': _replay,
    'python -m obs_ros.interface.usage': Session.python,
    'python -m obs_ros.observers.papers.design.h_infinity': _covered(
        'CVXPY is not among what tests need: `make test-design` runs it'
    ),
    'ros2 run obs_ros': Session.run,
    'ros2 run obs_ros replay': _replay,
    'ros2 run rqt_plot': _plot,
    'ros2 run plotjuggler': _layout,
    'ros2 topic echo': Session.echo,
    'ros2 param set': Session.set_parameter,
    'ros2 param get': Session.get_parameter,
    'ros2 param dump': Session.dump_parameters,
    'ros2 service call': Session.call,
    'ros2 bag play': _play,
    'ros2 security': _covered('SROS2 is not among the wheels'),
}
