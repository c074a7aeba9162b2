"""Nodes in this process, each test in a ROS context and domain of its own."""

import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from patience import patience
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from demo.domain import Domain
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.messages import STREAM, named_vector

# Nothing in the tests may talk outside this machine.
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'


class Ros:
    """A context with an executor; `node` is there to talk to the nodes under test."""

    def __init__(self, *args: str) -> None:
        self.context = rclpy.Context()
        self._domain = Domain()
        rclpy.init(args=list(args), context=self.context, domain_id=self._domain.number)
        self.executor = SingleThreadedExecutor(context=self.context)
        self._nodes: list[Node] = []
        self.node = self._add(Node('test', context=self.context))

    def start(self, kind: Callable[..., Node], *cli: str, **parameters: Any) -> Any:
        """Return a started node of that kind; `__` in a parameter's name stands for a dot.

        Streams go stale late, unless the command line speaks for itself or `parameters` do: a busy
        machine is no broken sensor.
        """
        if kind is Estimator and not cli:
            parameters.setdefault('stale_after', patience(5.0))
        overrides = [Parameter(k.replace('__', '.'), value=v) for k, v in parameters.items()]
        return self._add(
            kind(context=self.context, parameter_overrides=overrides, cli_args=list(cli))
        )

    def spin_until(self, predicate: Callable[[], Any], timeout: float = 10.0) -> Any:
        """Spin until `predicate` holds and return its value; fail after `patience(timeout)`."""
        end = time.monotonic() + patience(timeout)
        while not (value := predicate()):
            assert time.monotonic() < end, f'nothing came of it within {patience(timeout)} s'
            self.executor.spin_once(timeout_sec=0.02)
        return value

    def listen(self, topic: str, kind: type = JointState, qos: Any = STREAM) -> list[Any]:
        """Return a list that collects the messages on `topic`, once a publisher is there."""
        messages: list[Any] = []
        subscription = self.node.create_subscription(kind, topic, messages.append, qos)
        self.spin_until(subscription.get_publisher_count)
        return messages

    def speak(self, topic: str, qos: Any = STREAM, *, heard: bool = True) -> Callable[..., None]:
        """Return a function (seconds, names, values) that publishes, once it is `heard`."""
        publisher = self.node.create_publisher(JointState, topic, qos)
        if heard:
            self.spin_until(publisher.get_subscription_count)
        return lambda t, names, values: publisher.publish(
            named_vector(round(t * 1e9), names, [float(v) for v in values])
        )

    def call(self, service: str, kind: type, **fields: Any) -> Any:
        """Return the response of a service."""
        client = self.node.create_client(kind, service)
        self.spin_until(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        self.spin_until(future.done)
        return future.result()

    def health(self, *, outcome: str | None = None, timeout: float = 10.0) -> Any:
        """Return the next diagnostics, with that outcome, as a status; see `figures`."""
        arrays = self.listen('/diagnostics', DiagnosticArray)

        def found() -> Any:
            statuses = [array.status[0] for array in arrays]
            return [s for s in statuses if outcome is None or figures(s)['outcome'] == outcome]

        return self.spin_until(found, timeout)[-1]

    def stop(self, node: Node) -> None:
        """End a node."""
        closed = getattr(node, 'close', lambda: True)
        assert any(closed() for _ in range(100)), 'a thread does not end'
        self.executor.remove_node(node)
        self._nodes.remove(node)
        node.destroy_node()

    def close(self) -> None:
        """End all nodes, and the context."""
        for node in tuple(self._nodes):
            self.stop(node)
        self.executor.shutdown()
        self.context.try_shutdown()
        self._domain.close()

    def _add(self, node: Node) -> Node:
        self.executor.add_node(node)
        self._nodes.append(node)
        return node


class Waiting:
    """A steady clock for a simulator, which stands still while `behind()`: nothing is overrun."""

    def __init__(self) -> None:
        self.behind: Callable[[], Any] = lambda: False
        self._told = self._now = time.monotonic()

    def __call__(self) -> float:
        """Return the time in s: at most a tenth of a second after what was told before."""
        now = time.monotonic()
        if not self.behind():
            self._told += min(now - self._now, 0.1)
        self._now = now
        return self._told


def entities(node: Node) -> dict[str, int]:
    """Return the numbers of what a node has of each kind."""
    kinds = ('publishers', 'subscriptions', 'services', 'timers', 'guards', 'waitables')
    return {kind: len([*getattr(node, kind)]) for kind in kinds}


def solvers() -> set[threading.Thread]:
    """Return the threads of this process that solve; one that ends takes a moment for it."""
    return {thread for thread in threading.enumerate() if thread.name == 'solver'}


def figures(status: Any) -> dict[str, str]:
    """Return the figures of a diagnostic status by name."""
    return {entry.key: entry.value for entry in status.values}


def set_parameter(node: Node, name: str, value: Any) -> SetParametersResult:
    """Set one parameter as a remote caller does, and return the answer."""
    return node.set_parameters([Parameter(name, value=value)])[0]


def vector(message: JointState, names: Sequence[str] | None = None) -> dict[str, float]:
    """Return a named vector as a dict."""
    values = dict(zip(message.name, message.position, strict=True))
    return values if names is None else {name: values[name] for name in names}
