"""Reads orders in this process, for an engine that need not meet deadlines."""

from __future__ import annotations

import pickle
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.engine.asking.orders import free_ids
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import ActionTypes, MadeScript
from bt_orchestrator.script.orders.desk import OrderDesk, Question, Reading, Wanted


class DeskHere:
    """Makes jobs of orders at once. Implements `handler.OrderReading`."""

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        trees: Sequence[Path],
        state: CellState,
        *,
        any_path: bool = True,
    ) -> None:
        """Read scripts, by name in some folders or by path.

        :param state: of the engine that the orders are for
        :param any_path: also scripts outside the folders
        """
        self._desk = OrderDesk(cell, types, trees, any_path=any_path)
        self._state = state

    @asynccontextmanager
    async def read(self, wanted: Wanted | Callable[[], Wanted]) -> AsyncIterator[Reading]:
        """Read them now.

        :raises NotRead: says why nothing was read
        """
        yield self.reading(wanted() if callable(wanted) else wanted)

    def script(self, name: str) -> Script | Refused:
        """Read a script."""
        return self._desk.script(name)

    def made(self, made: MadeScript) -> Script | Refused:
        """Read a script that was generated."""
        return self._desk.made(made)

    def reading(self, wanted: Wanted) -> Reading:
        """Return what becomes of orders in the state of now."""
        scripts = self._state.scripts
        live = tuple(name for name, one in scripts.items() if one.dependencies)
        sent = {name: pickle.dumps(one) for name, one in scripts.items()}
        ids = free_ids(wanted, self._state)
        return self._desk.answer(Question(wanted, ids, live, sent))
