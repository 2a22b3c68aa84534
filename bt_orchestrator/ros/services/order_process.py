"""The process in which orders and scripts are read and proven (decision 0026)."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.base.child_process import ChildProcess, be_modest, serve
from bt_orchestrator.base.errors import NotRead
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.script.orders.desk import OrderDesk, Question
from bt_orchestrator.script.orders.desk_pickles import pickled

NICE = 10
"""A lower priority than the line, and a higher one than forecasts, which can wait."""


def order_process(cell: Cell, trees: Sequence[Path], *, any_path: bool) -> ChildProcess:
    """Return the process of a cell, not started yet."""
    return ChildProcess(__name__, pickle.dumps((cell, tuple(trees), any_path)))


class _Answers:
    """The knowledge of the process: the cell of the first question, and scripts."""

    def __init__(self) -> None:
        self._desk: OrderDesk | None = None

    def __call__(self, data: bytes) -> bytes:
        try:
            return self._answer(pickle.loads(data))
        except MemoryError:
            why = 'reading this takes more memory than a request may have; give fewer orders'
        except Exception as error:  # noqa: BLE001 - told to the client, and the next one is read
            why = f'reading this failed, which is a defect of the orchestrator: {error!r}'
        return pickle.dumps(NotRead(why))

    def _answer(self, question: object) -> bytes:
        if isinstance(question, Question):
            assert self._desk is not None
            return pickled(self._desk.answer(question), question.held)
        assert isinstance(question, tuple)
        self._desk = _desk(*question)
        return b''


def _desk(cell: Cell, trees: tuple[Path, ...], any_path: bool) -> OrderDesk:
    from bt_orchestrator.ros.types.action_types import InstalledActionTypes

    return OrderDesk(cell, InstalledActionTypes(), trees, any_path=any_path)


def main() -> None:
    """Read until the reader of the answers is gone."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
