"""Work orders that come over ROS 2: read, checked and bound to their scripts (formats)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import RefusedRequest
from bt_orchestrator.model.order import Job, WorkOrder
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.runtime.command_record import ADD
from bt_orchestrator.runtime.orders import FITS
from bt_orchestrator.script.admission import admit
from bt_orchestrator.script.lookup import find_below, find_script
from bt_orchestrator.script.order_file import (
    OrderPlaces,
    bind_order,
    params_from_text,
    parse_draft,
)
from bt_orchestrator.script.parameter_uses import action_types
from bt_orchestrator.script.script_file import read_script

PREFIX = 'WO-'
"""Of the ids that are assigned to orders without one."""

ANY_PATH = '--script-paths'
"""The option of the node that allows paths outside its folders."""


class OrderReader:
    """Makes jobs of what clients ask for. Nothing is changed here."""

    def __init__(
        self,
        state: CellState,
        types: ActionTypes,
        trees: Sequence[Path],
        *,
        any_path: bool,
    ) -> None:
        """Read scripts for clients.

        :param trees: folders in which scripts are looked up
        :param any_path: whether a client may also name a script elsewhere by its path; any
            participant of the ROS 2 domain is a client
        """
        self._state = state
        self._types = types
        self._types_by_component = action_types(state.cell, types)
        self._trees = trees
        self._find = find_script if any_path else partial(find_below, option=ANY_PATH)

    def jobs(self, orders: Sequence[Any]) -> list[Job | Refused]:
        """Make a job of each order (bt_orchestrator_interfaces/msg/WorkOrder), or say why not.

        Orders without an id get the next ones that were never used, here or before.
        """
        ids = self._free_ids({order.order for order in orders})
        return [self._job_or_refusal(order, ids) for order in orders]

    def job_of_text(self, text: str) -> Job:
        """Make a job of a work order as it stands in a file.

        :raises Refused: with every mistake
        """
        draft = parse_draft(text, 'order')
        order, places = draft.order, draft.places
        if not places.is_sure('script'):
            raise Refused(places.findings)
        try:
            script = self._script(order.script)
        except Refused as refused:
            raise Refused([*places.findings, *refused.findings]) from None
        return self._bound(order, script, self._free_ids({order.order or ''}), places)

    def changed(self, name: str, request: Any) -> Job | None:
        """Make of a queued job what a request (srv/QueueUpdate) wants it to be.

        What the request leaves open stays; parameters that a new script does not have are gone.

        :return: None if there is no such job
        :raises Refused: with every mistake
        """
        live = self._state.jobs.get(name)
        if live is None:
            return None
        script = self._script(request.script) if request.script else live.job.script
        kept = {key: value for key, value in live.job.params.items() if key in script.params}
        given = params_from_text(_texts(request.params), script)
        quantity = request.quantity or live.job.quantity
        order = WorkOrder(script.name, name, quantity, {**kept, **given})
        return self._bound(order, script, iter(()))

    def _job_or_refusal(self, order: Any, ids: Iterator[str]) -> Job | Refused:
        try:
            script = self._script(order.script)
            params = params_from_text(_texts(order.params), script)
            wanted = WorkOrder(order.script, order.order or None, order.quantity or None, params)
            return self._bound(wanted, script, ids)
        except Refused as refused:
            return refused

    def _script(self, name: str) -> Script:
        """Read and prove a script.

        :raises Refused: with every mistake in it
        """
        path = self._find(name, self._trees)
        script = read_script(path, self._state.cell, self._types)
        admit(path, script)
        return script

    def _bound(
        self,
        order: WorkOrder,
        script: Script,
        ids: Iterator[str],
        places: OrderPlaces | None = None,
    ) -> Job:
        name = order.order or next(ids)
        return bind_order(order, script, name, places, types=self._types_by_component)

    def _free_ids(self, taken: Collection[str]) -> Iterator[str]:
        return (name for name in self._state.order_ids.free(PREFIX) if name not in taken)


def name_of(order: Any) -> str:
    """Return the words by which a client knows its order (msg/WorkOrder)."""
    return str(order.order or order.script or 'the order')


def refused_orders(orders: Sequence[Any], read: Sequence[Job | Refused], by: By) -> RefusedRequest:
    """Return what is put on record of orders that were read, some of them with mistakes."""
    each = [
        f'{one.id} {FITS}' if isinstance(one, Job) else f'{name_of(order)} is {one.in_short}'
        for order, one in zip(orders, read, strict=True)
    ]
    ids = tuple(
        one.id if isinstance(one, Job) else order.order
        for order, one in zip(orders, read, strict=True)
    )
    return RefusedRequest(ADD, by, '; '.join(each), ids, tuple(each))


def _texts(params: Sequence[Any]) -> Mapping[str, str]:
    return {param.key: param.value for param in params}
