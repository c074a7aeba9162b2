"""A node that no failure of one of its callbacks ends."""

import functools
from collections.abc import Callable
from typing import Any

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import JumpHandle, JumpThreshold
from rclpy.duration import Duration
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node

from obs_ros.core.texts import quoted


class Failures:
    """Exceptions of callbacks, which end nothing: counted, and the newest in words."""

    def __init__(self) -> None:
        self.count = 0
        self.last = ''
        self._seen = 0

    def add(self, where: str, error: Exception) -> bool:
        """Note an exception; return whether it is another one than the last."""
        before, self.last = self.last, f'{where} failed: {quoted(error)}'
        self.count += 1
        return self.last != before

    def news(self) -> bool:
        """Return whether there was one since the last call."""
        before, self._seen = self._seen, self.count
        return self.count > before


class GuardedNode(Node):
    """Goes on after a callback that raises: `failures` counts, and the log names each new kind.

    A service answers that it failed, where its response has a field for that.
    """

    failures: Failures

    def __init__(self, name: str, **options: Any) -> None:
        self.failures = Failures()  # rclpy makes services and subscriptions of its own
        super().__init__(name, **options)

    def get_logger(self) -> RcutilsLogger:
        """Return the node's logger; rclpy does not say what it returns."""
        logger: RcutilsLogger = super().get_logger()  # type: ignore[no-untyped-call]
        return logger

    def create_timer(
        self, timer_period_sec: float, callback: Callable[..., Any], *rest: Any, **more: Any
    ) -> Any:
        """Create a timer whose callback is guarded."""
        return super().create_timer(timer_period_sec, self._guarded(callback), *rest, **more)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[..., Any], *rest: Any, **more: Any
    ) -> Any:
        """Create a subscription whose callback is guarded."""
        guarded = self._guarded(callback)
        return super().create_subscription(msg_type, topic, guarded, *rest, **more)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any], *rest: Any, **more: Any
    ) -> Any:
        """Create a service whose callback is guarded."""
        guarded = self._guarded(callback, answers=True)
        return super().create_service(srv_type, srv_name, guarded, *rest, **more)

    def create_guard_condition(self, callback: Callable[..., Any], *rest: Any, **more: Any) -> Any:
        """Create a guard condition whose callback is guarded."""
        return super().create_guard_condition(self._guarded(callback), *rest, **more)

    def guard_services(self) -> None:
        """Guard the services that rclpy has made without `create_service`."""
        for service in self.services:
            if not hasattr(service.callback, '__wrapped__'):
                service.callback = self._guarded(service.callback, answers=True)

    def watch_clock(self, callback: Callable[..., Any]) -> JumpHandle:
        """Call `callback(jump)` when the node's time has jumped back, until it is unregistered.

        The handle must be kept: dropping it ends the callback.
        """
        back = Duration(nanoseconds=-1)
        return self.get_clock().create_jump_callback(
            JumpThreshold(min_forward=None, min_backward=back, on_clock_change=False),
            post_callback=self._guarded(callback),
        )

    def destroy_node(self) -> None:
        """End the node, and all that belongs to it."""
        super().destroy_node()  # type: ignore[no-untyped-call]

    def _guarded(self, callback: Callable[..., Any], *, answers: bool = False) -> Any:
        where = getattr(callback, '__name__', type(callback).__name__).strip('_')

        @functools.wraps(callback)  # rclpy looks at the signature
        def guarded(*arguments: Any) -> Any:
            try:
                return callback(*arguments)
            except Exception as error:
                # While ROS shuts down whatever is under way may fail.
                if rclpy.ok(context=self.context) and self.failures.add(where, error):
                    self.get_logger().error(f'{self.failures.last}; the node goes on')
                return self._refused(*arguments) if answers else None

        return guarded

    def _refused(self, request: Any, response: Any) -> Any:
        """Return the response, saying why, of any service that can say so."""
        why = self.failures.last
        if hasattr(response, 'success'):
            response.success, response.message = False, why
        elif hasattr(response, 'results'):
            refused = SetParametersResult(successful=False, reason=why)
            response.results = [refused] * len(request.parameters)
        elif isinstance(getattr(response, 'result', None), SetParametersResult):
            response.result = SetParametersResult(successful=False, reason=why)
        return response
