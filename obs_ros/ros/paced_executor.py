"""An executor for many nodes: messages wake it, at most so often; all else it looks after by turns.

The executors of rclpy collect all that nodes have anew for each callback: of fifty estimators that
are 2300 entities, and some 10 ms. Here only what is urgent wakes the process, and each time it does
all of it is handled.
"""

import contextlib
import time
from collections import deque
from collections.abc import Callable, Coroutine, Iterable
from dataclasses import dataclass
from typing import Any

from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.waitable import NumberOfEntities

KINDS = ('subscription', 'guard_condition', 'timer', 'client', 'service')


@dataclass(frozen=True)
class Pace:
    """Wall times (s) of the executor."""

    wake: float = 0.01  # from one wake to the next: ten messages of fifty plants cost one wake
    services: float = 0.05  # from one look for calls to the next; a person does not notice
    events: float = 1.0  # the same for events of the middleware, such as QoS that do not match


class Watch:
    """Entities that are looked at together, by one set that is filled anew each time."""

    def __init__(
        self, context: Context, kinds: dict[str, list[Any]], waitables: list[Any] | None = None
    ) -> None:
        self._handles = {kind: [each.handle for each in all_] for kind, all_ in kinds.items()}
        self._by_pointer = {
            kind: {each.handle.pointer: each for each in all_} for kind, all_ in kinds.items()
        }
        self._waitables = waitables or []
        count = NumberOfEntities(*(len(self._handles.get(kind, ())) for kind in KINDS))
        for waitable in self._waitables:
            count += waitable.get_num_entities()
        self._set: Any = rclpy_implementation.WaitSet(
            count.num_subscriptions, count.num_guard_conditions, count.num_timers,
            count.num_clients, count.num_services, count.num_events, context.handle,
        )  # fmt: skip

    def ready(self, timeout: float) -> list[tuple[str, Any]]:
        """Wait up to so many s; return kinds and entities that are ready, in order of kind."""
        self._set.clear_entities()
        for kind, handles in self._handles.items():
            add = getattr(self._set, f'add_{kind}')
            for handle in handles:
                add(handle)
        for waitable in self._waitables:
            waitable.add_to_wait_set(self._set)
        self._set.wait(int(timeout * 1e9))
        found = [
            (kind, entities[pointer])
            for kind, entities in self._by_pointer.items()
            for pointer in self._set.get_ready_entities(kind)
        ]
        found += [('waitable', each) for each in self._waitables if each.is_ready(self._set)]
        return found


class PacedExecutor(Executor):
    """Runs callbacks in the thread that spins; entities must come and go in that thread only.

    Each wake takes what is ready in its turn, and one message of each topic, so that none that
    floods keeps others waiting.
    """

    def __init__(self, *, context: Context | None = None, pace: Pace = Pace()) -> None:
        super().__init__(context=context)
        self._pace = pace
        self._changed = True
        self._watches: list[Watch] = []  # urgent, services, events
        self._suspended: list[Coroutine[Any, Any, None]] = []  # callbacks that await something
        self._looked = [0.0, 0.0, 0.0]  # when each was looked at (steady clock, s)

    def wake(self) -> None:
        """Note that entities came or went."""
        self._changed = True
        super().wake()

    def add_node(self, node: Node) -> bool:
        """Serve a node; return whether it is new."""
        self._changed = True
        return bool(super().add_node(node))

    def remove_node(self, node: Node) -> None:
        """Serve a node no more."""
        self._changed = True
        super().remove_node(node)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait up to so many s (None: until the next look at services), and serve what is ready."""
        begun = time.monotonic()
        time.sleep(max(0.0, min(self._looked[0] + self._pace.wake - begun, timeout_sec or 1.0)))
        self._check_context()
        if self._changed:
            self._collect()
        now = time.monotonic()
        left = self._looked[1] + self._pace.services - now
        if timeout_sec is not None and timeout_sec >= 0.0:
            left = min(left, begun + timeout_sec - now)
        self._serve(self._watches[0].ready(max(0.0, left)))
        self._looked[0] = now = time.monotonic()
        for k, period in ((1, self._pace.services), (2, self._pace.events)):
            if not self._changed and now >= self._looked[k] + period:
                self._looked[k] = now
                self._serve(self._watches[k].ready(0.0))

    def _collect(self) -> None:
        """Gather the entities of all nodes."""
        self._changed = False
        nodes = self.get_nodes()

        def all_of(kind: str) -> list[Any]:
            return [entity for node in nodes for entity in getattr(node, kind)]

        guards = [*all_of('guards'), self._guard, self._sigint_gc]
        urgent = {
            'timer': all_of('timers'),
            'subscription': all_of('subscriptions'),
            'guard_condition': guards,
        }
        self._watches = [
            Watch(self._context, urgent),
            Watch(self._context, {'client': all_of('clients'), 'service': all_of('services')}),
            Watch(self._context, {}, all_of('waitables')),
        ]

    def _serve(self, ready: Iterable[tuple[str, Any]]) -> None:
        self._check_context()
        waiting = deque(ready)
        while waiting and not self._changed:
            kind, entity = waiting.popleft()
            if kind == 'timer' and not entity.handle.is_timer_ready():
                continue  # cancelled meanwhile
            if entity not in (self._guard, self._sigint_gc):
                self._run(getattr(self, f'_take_{kind}')(entity))
        # What is left may be gone. What is there is ready again, but for guards, which say so once.
        for kind, entity in waiting:
            if kind == 'guard_condition':
                with contextlib.suppress(InvalidHandle):
                    entity.trigger()
        suspended, self._suspended = self._suspended, []
        for callback in suspended:
            self._go_on(callback)
        with self._tasks_lock:
            tasks, self._tasks = [task for task, *_ in self._tasks], []
        for task in tasks:
            self._go_on_with_task(task)

    def _check_context(self) -> None:
        if not self._context.ok():
            raise ExternalShutdownException

    def _run(self, work: Callable[[], Coroutine[Any, Any, None]] | None) -> None:
        # A Task of rclpy, with its locks and callbacks, would cost as much as reading a message.
        if work is not None:
            self._go_on(work())

    def _go_on(self, callback: Coroutine[Any, Any, None]) -> None:
        """Let a callback run as far as it can; one that awaits goes on at the next wake."""
        with contextlib.suppress(StopIteration):
            callback.send(None)
            self._suspended.append(callback)

    def _go_on_with_task(self, task: Any) -> None:
        """Do so with what others have asked the executor to run."""
        task()
        if not task.done():
            with self._tasks_lock:
                self._tasks.append((task, None, None))
        elif task.exception() is not None:
            raise task.exception()
