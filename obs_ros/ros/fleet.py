"""Many estimators in one process: one executor, one pool of threads, one set of kernels a model."""

import os
import sys
import time
from collections import Counter
from collections.abc import Mapping
from typing import Any

from rclpy.exceptions import ParameterException
from rclpy.node import Node

from obs_ros.core.texts import one_line
from obs_ros.interface.checkpoint_writer import CheckpointWriter
from obs_ros.interface.fleet import FLEET, OWN, FleetHealth, plants
from obs_ros.interface.pool import Pool
from obs_ros.interface.status import Health
from obs_ros.ros.diagnostics import publish_health
from obs_ros.ros.estimator import Estimator
from obs_ros.ros.guarded import GuardedNode
from obs_ros.ros.info import publish_info, settings_info
from obs_ros.ros.lean_middleware import lean_middleware
from obs_ros.ros.paced_executor import PacedExecutor
from obs_ros.ros.parameters import Parameters, given_at_start
from obs_ros.ros.run import run

# s after which a thread of Python lets another go on. After each kernel a solve waits for its turn:
# at Python's 5 ms, beside callbacks that are hardly ever idle, windows took seconds.
TURN = 2e-4


class Fleet(GuardedNode):
    """Runs an estimator in each of the namespaces `plants`, which may change while it runs.

    Estimators get the same `options` and arguments as the fleet, so that a parameter given without
    a node's name holds for all of them. One that cannot start is told, and harms no other. They
    share a pool of threads, which solves the window first whose deadline is the earliest.

    Raises ValueError when its own parameters are wrong, or when none of its plants can start.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__('fleet', automatically_declare_parameters_from_overrides=True, **options)
        self._options = options
        self.estimators: dict[str, Estimator] = {}
        self.refused: dict[str, str] = {}  # why plants could not start
        self._wanted: tuple[str, ...] = ()
        parameters = Parameters(self, given_at_start(self, ours=OWN.__contains__))
        parameters.declare(FLEET)
        workers = parameters.values['workers'] or len(os.sched_getaffinity(0))
        self._pool, self._writer = Pool(workers), CheckpointWriter()
        self._health, self._examined = FleetHealth(workers), time.monotonic()
        self._guard = self.create_guard_condition(self._change)
        self._publish_info = publish_info(self)
        try:
            parameters.watch(self._propose, self._adopt)
            while self._step():
                pass
            if self.refused and not self.estimators:
                raise ValueError(next(iter(self.refused.values())))
        except BaseException:
            self.close()
            raise
        publish_health(self, lambda: 'fleet', self._examine)

    @property
    def nodes(self) -> list[Node]:
        """All nodes of the process."""
        return [self, *self.estimators.values()]

    def close(self) -> bool:
        """End the threads; False when a solve has not ended in time."""
        self._pool.close()
        return all([each.close() for each in self.estimators.values()])

    def destroy_node(self) -> None:
        """End all nodes."""
        for each in self.estimators.values():
            each.destroy_node()
        super().destroy_node()

    def _propose(self, values: Mapping[str, Any]) -> tuple[tuple[str, ...], Mapping[str, Any]]:
        return plants(values['plants']), values

    def _adopt(self, proposal: tuple[tuple[str, ...], Mapping[str, Any]]) -> None:
        self._wanted, settings = proposal
        self.refused = {}
        self._publish_info(settings_info(settings))
        self._guard.trigger()

    def _change(self) -> None:
        """Start or end one plant, so that those that run get their turn before the next."""
        if self._step():
            self._guard.trigger()

    def _step(self) -> bool:
        """Start or end one plant; return whether there was one."""
        for name in [*self.estimators]:
            if name not in self._wanted:
                self._end(name)
                return True
        for name in self._wanted:
            if name not in self.estimators and name not in self.refused:
                self._begin(name)
                return True
        return False

    def _begin(self, name: str) -> None:
        try:
            estimator = Estimator(
                pool=self._pool, writer=self._writer, **{**self._options, 'namespace': name}
            )
            if estimator.get_namespace() != name:
                estimator.close(0.0)
                estimator.destroy_node()
                raise ValueError('take __ns away: with it all plants would have one name')
        except (ValueError, RuntimeError, ParameterException) as error:
            self.refused[name] = f'{name}: {one_line(error)}'
            self.get_logger().error(f'not started: {self.refused[name]}')
            return
        self.estimators[name] = estimator
        if self.executor is not None:
            self.executor.add_node(estimator)

    def _end(self, name: str) -> None:
        estimator = self.estimators.pop(name)
        if self.executor is not None:
            self.executor.remove_node(estimator)
        estimator.close(0.0)  # its solve may go on: nobody hears of it
        estimator.destroy_node()
        self.get_logger().info(f'ended: {name}')

    def _examine(self) -> Health:
        before, self._examined = self._examined, time.monotonic()
        running = {name: each.status() for name, each in self.estimators.items()}
        there = Counter(
            f'{space.rstrip("/")}/{name}' for name, space in self.get_node_names_and_namespaces()
        )
        own = [each.get_fully_qualified_name() for each in self.estimators.values()]
        twice = [name for name in own if there[name] > 1]
        return self._health.examine(running, self.refused, twice, self._examined - before)


def main() -> int:
    """Run the fleet as a process."""
    sys.setswitchinterval(TURN)
    return run('fleet', _lean, executor=PacedExecutor)


def _lean() -> Fleet:
    with lean_middleware():
        return Fleet()


if __name__ == '__main__':
    sys.exit(main())
