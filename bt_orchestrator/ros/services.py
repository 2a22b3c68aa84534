"""What the node can be asked about its cell: answers to holds, items taken off, commands."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import AnswerHold, Command, RemoveItem
from rclpy.node import Node

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import commands
from bt_orchestrator.ros.cell_command import command_of
from bt_orchestrator.ros.serving import by, serve, tell
from bt_orchestrator.runtime.orchestrator import Orchestrator


class Services:
    """The services that are about cell and items."""

    def __init__(self, node: Node, orchestrator: Orchestrator) -> None:
        self._orchestrator = orchestrator
        serve(node, AnswerHold, 'answer_hold', self._answer)
        serve(node, RemoveItem, 'remove_item', self._remove)
        serve(node, Command, 'command', self._command)

    def _answer(self, request: Any, response: Any) -> None:
        command = commands.AnswerHold(request.hold, request.answer, by(request))
        tell(response, self._orchestrator.ask(command))

    def _remove(self, request: Any, response: Any) -> None:
        command = commands.RemoveItem(request.item, by(request))
        tell(response, self._orchestrator.ask(command))

    def _command(self, request: Any, response: Any) -> None:
        try:
            command: commands.Command = command_of(request)
        except CommandRefused as refused:
            command = commands.RefusedRequest(request.command, by(request), str(refused))
        tell(response, self._orchestrator.ask(command))
        response.state = self._orchestrator.state.mode.value
