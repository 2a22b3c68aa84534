"""Running simulated controllers as a process, from the ready line to a clean end."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import rclpy
import rclpy.utilities
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.base.stop_signals import StopSignals, leaving
from bt_orchestrator.sim.controllers.node import ControllerNode, Setup
from bt_orchestrator.sim.controllers.task_server import report

_LAST_WORDS_S = 2.0
"""Longest time for telling clients that their goals were aborted."""


class BadRosArguments(OrchestratorError):
    """The words behind --ros-args cannot be understood."""


def run_controllers(
    setup: Setup,
    stop: StopSignals,
    on_ready: Callable[[str], None],
    ros_args: Sequence[str] = (),
) -> None:
    """Serve until a stop signal, then abort the tasks in hand and leave.

    :param on_ready: called once, with a line about what is there, when all servers are up
    :param ros_args: a command line; what is not between --ros-args and -- is ignored
    :raises BadRosArguments: ROS cannot read them
    """
    with _ros_args_refused():
        # rclpy's own handlers would end the context before clients were told.
        rclpy.init(args=list(ros_args), signal_handler_options=SignalHandlerOptions.NO)
    try:
        _serve(setup, stop, on_ready)
    finally:
        setup.log.close()
        with leaving():
            rclpy.shutdown()


def without_ros_args(command_line: Sequence[str]) -> list[str]:
    """Return a command line without what stands between --ros-args and --.

    :raises BadRosArguments: ROS cannot read them
    """
    with _ros_args_refused():
        return list(rclpy.utilities.remove_ros_args(list(command_line)))


@contextmanager
def _ros_args_refused() -> Iterator[None]:
    try:
        yield
    except RuntimeError as error:
        raise BadRosArguments(f'ROS refuses its arguments: {error}') from error


def _serve(setup: Setup, stop: StopSignals, on_ready: Callable[[str], None]) -> None:
    executor = SingleThreadedExecutor()
    node = ControllerNode(setup)
    executor.add_node(node)
    on_ready(node.ready_line)
    # The executor's own wake() would not make it return.
    stop.notify(lambda: executor.create_task(_nothing))
    while not stop.requested:
        try:
            executor.spin_once()
        except ExternalShutdownException:
            break
        except Exception:  # noqa: BLE001 - nothing may end the process
            report(node.get_logger())
    node.switch_off()
    executor.spin_until_future_complete(_two_turns(executor), _LAST_WORDS_S)
    stop.notify(_nothing)
    with leaving():
        executor.shutdown()
        node.destroy_node()


def _two_turns(executor: SingleThreadedExecutor) -> Future[None]:
    """Return what is done when everything was run that waits now, and what follows from it.

    An ended goal is one task, and the answers to its result requests are the next.
    """
    done: Future[None] = Future(executor=executor)
    executor.create_task(lambda: executor.create_task(done.set_result, None))
    return done


def _nothing() -> None:
    """Stand for a function that is not needed."""
