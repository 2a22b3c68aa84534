"""What the node can be asked about its cell: answers to holds, items taken off, commands."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import AnswerHold, Command, RemoveItem
from rclpy.node import Node

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import commands
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.ros.services.cell_command import command_of
from bt_orchestrator.ros.services.serving import by, serve, tell
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.script.given_results import given_results


class Services:
    """The services that are about cell and items."""

    def __init__(self, node: Node, orchestrator: Orchestrator, types: ActionTypes) -> None:
        self._orchestrator = orchestrator
        self._types = types
        serve(node, AnswerHold, 'answer_hold', self._answer)
        serve(node, RemoveItem, 'remove_item', self._remove)
        serve(node, Command, 'command', self._command)

    async def _answer(self, request: Any, response: Any) -> None:
        try:
            results = self._results(request) if request.results else {}
            command: commands.Command = commands.AnswerHold(
                request.hold, request.answer, by(request), results
            )
        except CommandRefused as refused:
            command = commands.RefusedRequest(request.answer, by(request), str(refused))
        tell(response, await self._orchestrator.carry_out(command))

    def _results(self, request: Any) -> dict[str, Any]:
        """Return the results that are given with an answer.

        :raises CommandRefused: they are none of the task that is held
        """
        state = self._orchestrator.state
        hold = state.holds.get(request.hold)
        task = state.task(hold.key) if hold is not None and hold.key is not None else None
        if task is None:
            raise CommandRefused(f'hold {request.hold} is about no task that can have results')
        return given_results(request.results, self._types.action(_type_of(state, task)))

    async def _remove(self, request: Any, response: Any) -> None:
        command = commands.RemoveItem(request.item, by(request))
        tell(response, await self._orchestrator.carry_out(command))

    async def _command(self, request: Any, response: Any) -> None:
        try:
            command: commands.Command = command_of(request)
        except CommandRefused as refused:
            command = commands.RefusedRequest(request.command, by(request), str(refused))
        tell(response, await self._orchestrator.carry_out(command))
        response.state = self._orchestrator.state.packml.value


def _type_of(state: CellState, task: Task) -> str:
    return state.cell.components[task.component].type
