"""Services about the cell: any request by its name, answers to holds, items, commands."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import AnswerHold, Command, MakeRequest, RemoveItem
from rclpy.node import Node

from bt_orchestrator.asking.handler import RequestHandler
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.requests import REMOVE_ITEM, About
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ros.services.senders import Senders
from bt_orchestrator.ros.services.serving import serve, tell
from bt_orchestrator.ros.types.status_messages import order_answer_message


class Services:
    """The services that are about cell and items; nothing is decided here."""

    def __init__(
        self, node: Node, handler: RequestHandler, senders: Senders, state: CellState
    ) -> None:
        self._handler = handler
        self._senders = senders
        self._state = state
        serve(node, AnswerHold, 'answer_hold', self._answer)
        serve(node, RemoveItem, 'remove_item', self._remove)
        serve(node, Command, 'command', self._command)
        serve(node, MakeRequest, 'request', self._request)

    async def _request(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        answer = await self._handler.carry_out_named(request.name, request.arguments, by)
        tell(response, answer)
        response.answers = list(map(order_answer_message, answer.orders))

    async def _answer(self, request: Any, response: Any) -> None:
        answer = await self._handler.give(
            About.HOLD,
            request.answer,
            self._senders.by(request),
            hold=request.hold,
            results=request.results,
        )
        tell(response, answer)

    async def _remove(self, request: Any, response: Any) -> None:
        answer = await self._handler.give(
            About.ITEM, REMOVE_ITEM.word, self._senders.by(request), item=request.item
        )
        tell(response, answer)

    async def _command(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        if request.component:
            answer = await self._handler.give(
                About.COMPONENT, request.command, by, component=request.component
            )
        elif request.script:
            answer = await self._handler.give(
                About.SCRIPT,
                request.command,
                by,
                script=request.script,
                cell_digest=request.cell_digest,
            )
        else:
            answer = await self._to_cell(request, by)
        tell(response, answer)
        response.state = self._state.packml.value

    async def _to_cell(self, request: Any, by: By) -> Answer:
        return await self._handler.give(
            About.CELL,
            request.command,
            by,
            hold=request.hold,
            everyones=request.everyones,
            belt=request.belt,
            as_shown=request.as_shown,
        )
