"""Services that answer every request, whatever is wrong with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.limits import MESSAGE, cut
from bt_orchestrator.ros.order_reader import OrderReader, Steps
from bt_orchestrator.ros.patient_service import Later, create_patient_service
from bt_orchestrator.ros.spare_log import SpareLog


def serve(node: Node, kind: Any, name: str, handle: Callable[[Any, Any], None]) -> None:
    """Offer a private service of a node.

    :param handle: fills the response; an exception becomes a refusal, and stops nothing
    """
    log = SpareLog(node.get_logger())

    def answer(request: Any, response: Any) -> Any:
        try:
            handle(request, response)
        except Exception as error:  # noqa: BLE001 - a bad request never stops the node
            _tell_of_failure(log, name, response, error)
        return response

    create_patient_service(node, kind, f'~/{name}', answer)


def serve_orders(
    node: Node, kind: Any, name: str, orders: OrderReader, handle: Callable[[Any, Any], Steps]
) -> None:
    """Offer a private service that answers when the orders of its request were read.

    :param handle: fills the response in steps, as above
    """
    log = SpareLog(node.get_logger())

    def answer(request: Any, response: Any) -> Any:
        later = Later()

        def ended(error: Exception | None) -> None:
            if error is not None:
                _tell_of_failure(log, name, response, error)
            later.answer(response)

        orders.follow(handle(request, response), ended)
        return later

    create_patient_service(node, kind, f'~/{name}', answer)


def _tell_of_failure(said: SpareLog, name: str, response: Any, error: Exception) -> None:
    said.error(f'{name} failed: {error!r}')
    response.accepted = False
    response.message = cut(f'internal error, see the log of the node: {error!r}', MESSAGE)


def tell(response: Any, answer: Answer) -> None:
    """Put an answer into a response."""
    response.accepted, response.message = answer.accepted, answer.message


def by(request: Any, otherwise: str = 'service') -> By:
    """Return who asks, from where, and why.

    :param otherwise: where from, if the request does not say it
    """
    return By(request.who, request.origin or otherwise, request.reason)
