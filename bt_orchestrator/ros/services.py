"""What the node can be asked: orders, answers to holds, items taken off the belt."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_orchestrator_interfaces.srv import AnswerHold, Command, RemoveItem, SubmitOrder
from rclpy.node import Node

from bt_orchestrator.errors import Refused
from bt_orchestrator.model import commands
from bt_orchestrator.model.order import Job, WorkOrder
from bt_orchestrator.ports import ActionTypes, AdmissionCheck
from bt_orchestrator.ros.patient_service import create_patient_service
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.script.admission import admit
from bt_orchestrator.script.lookup import find_script
from bt_orchestrator.script.order_file import bind_order, params_from_text
from bt_orchestrator.script.parameter_uses import action_types
from bt_orchestrator.script.script_file import read_script


class Services:
    """The node's services. Every request is answered, whatever is wrong with it."""

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        types: ActionTypes,
        trees: Sequence[Path],
        admission: AdmissionCheck,
    ) -> None:
        self._node = node
        self._orchestrator = orchestrator
        self._types = types
        self._types_by_component = action_types(orchestrator.state.cell, types)
        self._trees = trees
        self._admission = admission
        self._numbers = itertools.count(1)
        self._serve(SubmitOrder, 'submit_order', self._submit)
        self._serve(AnswerHold, 'answer_hold', self._answer)
        self._serve(RemoveItem, 'remove_item', self._remove)
        self._serve(Command, 'command', self._command)

    def _serve(self, kind: Any, name: str, handle: Callable[[Any, Any], None]) -> None:
        def answer(request: Any, response: Any) -> Any:
            try:
                handle(request, response)
            except Exception as error:  # noqa: BLE001 - a bad request never stops the node
                self._node.get_logger().error(f'{name} failed: {error!r}')
                response.accepted = False
                response.message = f'internal error, see the log of the node: {error!r}'
            return response

        create_patient_service(self._node, kind, f'~/{name}', answer)

    def _submit(self, request: Any, response: Any) -> None:
        try:
            job = self._job(request)
        except Refused as refused:
            response.message = f'refused with {len(refused.findings)} findings'
            response.findings = [str(finding) for finding in refused.findings]
            return
        answer = self._orchestrator.ask(commands.SubmitJob(job))
        response.accepted, response.message = answer.accepted, answer.message
        response.job = job.id if answer.accepted else ''

    def _job(self, request: Any) -> Job:
        """Read the script and bind the order to it.

        :raises Refused: with every mistake in either
        """
        path = find_script(request.script, self._trees)
        script = read_script(path, self._orchestrator.state.cell, self._types)
        admit(path, script, self._admission)
        params = {param.key: param.value for param in request.params}
        order = WorkOrder(
            request.script,
            request.order or None,
            request.quantity or None,
            params_from_text(params, script),
        )
        job_id = order.order or self._new_id()
        return bind_order(order, script, job_id, types=self._types_by_component)

    def _new_id(self) -> str:
        state = self._orchestrator.state
        names = (f'WO-{number}' for number in self._numbers)
        return next(name for name in names if name not in state.jobs and name not in state.ended)

    def _answer(self, request: Any, response: Any) -> None:
        command = commands.AnswerHold(request.hold, request.answer, request.who, request.reason)
        answer = self._orchestrator.ask(command)
        response.accepted, response.message = answer.accepted, answer.message

    def _remove(self, request: Any, response: Any) -> None:
        command = commands.RemoveItem(request.item, request.who, request.reason)
        answer = self._orchestrator.ask(command)
        response.accepted, response.message = answer.accepted, answer.message

    def _command(self, request: Any, response: Any) -> None:
        kind = _COMMANDS.get(request.command)
        if kind is None:
            known = ', '.join(_COMMANDS)
            response.message = f'unknown command {request.command!r}; one of {known}'
            return
        answer = self._orchestrator.ask(kind(request.who, request.reason))
        response.accepted, response.message = answer.accepted, answer.message


_COMMANDS: Mapping[str, type[commands.Pause] | type[commands.Resume]] = {
    'pause': commands.Pause,
    'resume': commands.Resume,
}
