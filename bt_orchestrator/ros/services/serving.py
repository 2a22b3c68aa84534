"""Services that answer every request, whatever is wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bt_orchestrator.base.replies import Steps, begin
from bt_orchestrator.model.limits import MESSAGE, cut
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.services.patient_service import create_patient_service


def serve(node: Node, kind: Any, name: str, handle: Callable[[Any, Any], Steps[None]]) -> None:
    """Offer a private service of a node, which answers when it has been handled.

    :param handle: fills the response; an exception becomes a refusal, and stops nothing
    """
    said = SpareLog(node.get_logger())

    async def answer(request: Any, response: Any) -> Any:
        try:
            await handle(request, response)
        except Exception as error:  # noqa: BLE001 - a bad request never stops the node
            said.error(f'{name} failed: {error!r}')
            response.accepted = False
            response.message = cut(f'internal error, see the log of the node: {error!r}', MESSAGE)
        return response

    create_patient_service(node, kind, f'~/{name}', lambda *asked: begin(answer(*asked)))
