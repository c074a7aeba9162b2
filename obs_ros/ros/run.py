"""Starting and ending a node as a process: exit codes, signals, one-line errors."""

import os
import signal
import sys
from collections.abc import Callable

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions, install_signal_handlers

from obs_ros.core.texts import one_line


def run(
    name: str,
    create: Callable[[], Node],
    args: list[str] | None = None,
    executor: Callable[[], Executor] = SingleThreadedExecutor,
) -> int:
    """Spin the node that `create` returns until a signal or shutdown ends it, and the process.

    A node that has others names all of them, and itself, as `nodes`. With exit code 0 after SIGINT,
    SIGTERM or a shutdown. Returns 1, with one line on stderr, when it cannot start. A node with a
    `close()` gets it called at the end. Nothing else is waited for: neither a thread in code that
    nothing can interrupt, nor Python, which takes its modules apart for ten times as long as the
    node takes to end.
    """
    node = None
    caught: list[int] = []
    try:
        # While things are half made, shutting down would leave tracebacks: so signals are noted
        # only, until the executor can see to them.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, _: caught.append(number))
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        node = create()
        spinning = executor()
        for each in getattr(node, 'nodes', [node]):
            spinning.add_node(each)
        install_signal_handlers(SignalHandlerOptions.ALL)
        if not caught:
            spinning.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    # ROS raises a RuntimeError where it cannot write its log.
    except (ValueError, ParameterException, RuntimeError) as error:
        if node is None:
            print(f'{name}: {_why(error)}', file=sys.stderr)
            return 1
        # rclpy shuts down from a thread, and what is just under way there fails: that is no defect.
        if rclpy.ok():
            raise
    finally:
        getattr(node, 'close', lambda: True)()
        if node is not None:
            node.destroy_node()  # else others would take it for alive for many seconds
        rclpy.try_shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _why(error: Exception) -> str:
    """Return the error in one line, with what to do about one that rcl leaves without a remedy."""
    text = one_line(error)
    if not isinstance(error, ValueError) and ('logging' in text or '.log' in text):
        return f'set ROS_LOG_DIR to a folder that can be written to: {text}'
    return text
