"""A newcomer's terminals: nodes as real processes, and what `ros2` does beside them."""

import argparse
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import yaml
from ament_index_python.packages import get_package_prefix
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from patience import patience
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros import Ros
from std_msgs.msg import String

from obs_ros.ros.messages import LATCHED

NODES = ('estimator', 'fleet', 'simulator', 'view')
TROUBLE = ('Traceback', '[ERROR]', '[FATAL]')  # in the words of a node that ends in peace


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
        self.printed: list[str] = []  # lines of all that has run to its end

    def hear_echoes(self) -> None:
        """Wait until every `echo` has printed something, all nodes being alive."""
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
        """End every node as Ctrl-C does."""
        for name in tuple(self.nodes):
            self.end(name)

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
        called = [w.removeprefix('__node:=') for w in arguments if w.startswith('__node:=')]
        kind, name = name, f'{"".join(spaces)}/{"".join(called) or name}'
        if name in self.nodes:  # whoever reads on ends the one before
            self.end(name)
        self._lines[name] = words
        with self._words(name).open('wb') as words_of_it:
            self.nodes[name] = subprocess.Popen(
                [path, *arguments], cwd=self.folder, env=self.environment,
                stdout=words_of_it, stderr=words_of_it, start_new_session=True,
            )  # fmt: skip
        if 'managed:=true' in arguments:  # it waits
            return
        if kind == 'view':  # it publishes nothing, but says where it is to be found
            self.ros.spin_until(lambda: 'open http' in self._told(name) or self._ended(), 30.0)
            return
        told = self.ros.listen(f'{name}/info', String, LATCHED)
        self.ros.spin_until(lambda: told or self._ended(), timeout=30.0)
        if kind == 'estimator':  # what comes once must not come before it is compiled
            self.ros.spin_until(lambda: 'ready' in self._told(name) or self._ended(), timeout=60.0)

    def python(self, words: list[str]) -> None:
        """`python -m MODULE ...`."""
        self._foreground([sys.executable, *words[1:]])

    def tool(self, words: list[str]) -> None:
        """Run a command of the system as it stands."""
        self._foreground(words)

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

    def transition(self, words: list[str]) -> None:
        """`ros2 lifecycle set NODE TRANSITION`, and `ros2 lifecycle get NODE`."""
        node, *asked = words[3:]
        if not asked:
            state = self.ros.call(f'{node}/get_state', GetState).current_state
            assert state.label
        for label in asked:
            answer = self.ros.call(
                f'{node}/change_state', ChangeState, transition=Transition(label=label)
            )
            assert answer.success, label

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
        self.printed += done.stdout.splitlines()

    def end(self, name: str) -> None:
        """End a node as Ctrl-C does: at once, with exit code 0 and no word of trouble."""
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

    def filled(self, word: str) -> str:
        """Put in what stands for something: other files, and the prefix of a package."""
        word = re.sub(r'\{prefix:(\w+)\}', lambda match: get_package_prefix(match[1]), word)
        for name, path in self.files.items():
            word = re.sub(rf'\b{name}(?=$|_)', path, word)
        return word


def _class(name: str) -> Any:
    package, kind, type_name = name.split('/')
    return getattr(import_module(f'{package}.{kind}'), type_name)
