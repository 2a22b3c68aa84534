"""The action server of one simulated controller."""

from __future__ import annotations

import traceback
import uuid
from collections.abc import Callable, Mapping
from typing import Any, Protocol, cast

from rclpy.action.server import (
    ActionServer,
    CancelResponse,
    GoalEvent,
    GoalResponse,
    ServerGoalHandle,
)
from rclpy.node import Node

from bt_orchestrator.model.goal import GoalStatus
from bt_orchestrator.sim.carrier import Verdict

_ANSWERS = {Verdict.ACCEPT: GoalResponse.ACCEPT, Verdict.REJECT: GoalResponse.REJECT}

SUB_TASK = 'current_sub_task'
STAMP = 'stamp'
"""Feedback fields that are filled where the type has them."""


class _Muted(Exception):
    """A goal request that gets no answer."""


class Requests(Protocol):
    """Decides on requests of clients."""

    def answer(self, goal_id: str, message: Any) -> Verdict:
        """Decide on a goal request."""

    def start(self, goal_id: str, handle: Any) -> None:
        """Begin a goal that was accepted."""

    def cancel(self, goal_id: str) -> bool:
        """Decide on a cancel request."""


class TaskServer(ActionServer):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Passes goals and answers on; decides nothing itself.

    A goal that runs is no coroutine: rclpy would resume every pending one in each turn of the
    executor. It is started by a callback, and its end becomes one short task.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        type_name: str,
        requests: Requests,
        interfaces: Interfaces,
        result_timeout_s: float,
    ) -> None:
        self._host = node
        self._requests = requests
        self._interfaces = interfaces
        self._asking = ''
        super().__init__(
            node,
            interfaces.action_class(type_name),
            name,
            execute_callback=_never_called,
            goal_callback=self._answer,
            handle_accepted_callback=self._start,
            cancel_callback=self._cancel,
            # Declared int, yet what is below takes fractions too.
            result_timeout=cast(int, result_timeout_s),
        )

    async def execute(self, taken_data: Any) -> None:
        """Handle what was taken from the middleware (rclpy's Waitable interface).

        Overridden for three things: the goal callback is not told the UUID, a request could not be
        left without an answer, and an exception would end the executor's loop.
        """
        if 'goal' in taken_data:
            self._asking = goal_id(taken_data['goal'][1])
        for kind, data in taken_data.items():
            part: Any = {kind: data}
            try:
                await super().execute(part)
            except _Muted:
                pass
            except Exception:  # noqa: BLE001 - whatever it is, the other servers go on
                report(self._host.get_logger())

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Do nothing when a goal starts (rclpy would run a callback to its end): see `end`."""

    def feedback(self, handle: ServerGoalHandle, text: str) -> None:  # type: ignore[type-arg]
        """Publish feedback on a goal."""
        message = self.action_type.Feedback()
        types = message.get_fields_and_field_types()
        if types.get(SUB_TASK) == 'string':
            setattr(message, SUB_TASK, text)
        if types.get(STAMP) == 'builtin_interfaces/Time':
            setattr(message, STAMP, self._host.get_clock().now().to_msg())
        handle.publish_feedback(message)

    def end(
        self,
        handle: ServerGoalHandle,  # type: ignore[type-arg]
        status: GoalStatus,
        result: Mapping[str, Any],
    ) -> None:
        """End a goal and answer all who ask for its result."""

        def conclude(handle: Any) -> Any:
            message = self.action_type.Result()
            self._interfaces.fill(message, result)
            _ENDS[status](handle)
            return message

        super().notify_execute(handle, conclude)

    def _answer(self, goal: Any) -> GoalResponse:
        verdict = self._requests.answer(self._asking, goal)
        if verdict is Verdict.MUTE:
            raise _Muted
        return _ANSWERS[verdict]

    def _start(self, handle: Any) -> None:
        handle.execute()
        self._requests.start(goal_id(handle), handle)

    def _cancel(self, handle: Any) -> CancelResponse:
        obeyed = self._requests.cancel(goal_id(handle))
        return CancelResponse.ACCEPT if obeyed else CancelResponse.REJECT


def goal_id(bearer: Any) -> str:
    """Return the goal UUID, as text, of whatever has a `goal_id` message."""
    return str(uuid.UUID(bytes=bytes(bearer.goal_id.uuid)))


def _never_called(handle: Any) -> Any:
    raise NotImplementedError


def _end_succeeded(handle: Any) -> None:
    handle.succeed()


def _end_aborted(handle: Any) -> None:
    handle.abort()


def _end_canceled(handle: Any) -> None:
    if not handle.is_cancel_requested:
        # A goal may end canceled only after a cancel request; for a server that cancels on its
        # own account rclpy has no public call.
        handle._update_state(GoalEvent.CANCEL_GOAL)  # noqa: SLF001
    handle.canceled()


_ENDS = {
    GoalStatus.SUCCEEDED: _end_succeeded,
    GoalStatus.ABORTED: _end_aborted,
    GoalStatus.CANCELED: _end_canceled,
}


# The ROS 2 message classes that are needed here; the entry point hands them in.


class Interfaces(Protocol):
    """The installed message and action classes, and how they are filled."""

    def action_class(self, name: str) -> Any:
        """Return the class of an action type such as pkg/action/Name."""

    def message_class(self, name: str) -> Any:
        """Return the class of a message type such as pkg/msg/Name."""

    def fill(self, message: Any, fields: Mapping[str, Any]) -> None:
        """Set fields from plain values; those of nested messages are mappings."""


# A callback's exception is reported, and never ends the process.


class Logger(Protocol):
    """The part of a ROS 2 logger that is needed here."""

    def error(self, message: str) -> object:
        """Report an error."""


def guarded(callback: Callable[[], object], logger: Logger) -> None:
    """Call back; rclpy would let an exception end the executor's loop."""
    try:
        callback()
    except Exception:  # noqa: BLE001 - whatever it is, the others go on
        report(logger)


def report(logger: Logger) -> None:
    """Report the exception that is being handled."""
    text = f'error in a callback, ignored:\n{traceback.format_exc()}'
    logger.error(text)
