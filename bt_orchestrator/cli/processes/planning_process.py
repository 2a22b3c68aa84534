"""Computes what-if of a running cell in a process of low priority.

The blackboard of py_trees is global to a process, and a virtual run takes the interpreter for
itself: neither is for a process that serves somebody meanwhile.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.base.child_process import ChildFailed, ChildProcess, be_modest, serve
from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ports import ActionTypes, CheckedOrder, Consequence, Moment, Proposal
from bt_orchestrator.script.orders.by_recipe import Maker, recipes

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

WITHIN_S = 60.0
"""Longest time for an answer; the runs themselves give up earlier."""

PROPOSED_WITHIN_S = 300.0
"""The same for a proposal, which is bounded by the steps of its runs and not by time."""


class PlanningProcess:
    """Asks the process, which starts with the first question. Implements `ports.Planning`."""

    def __init__(
        self,
        trees: Sequence[Path] = (),
        recipes: Sequence[Path] = (),
        *,
        any_path: bool = False,
    ) -> None:
        """Prepare; nothing is started yet.

        :param trees: folders in which the scripts of new orders are looked up
        :param recipes: the same for recipes
        :param any_path: whether an order may also name a script elsewhere, by its path
        """
        setup = _Setup(tuple(trees), tuple(recipes), any_path)
        self._process = ChildProcess(__name__, pickle.dumps(setup))

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        :raises NotKept: the moment cannot be gone on from
        """
        consequence: Consequence = self._ask('ask', moment, tuple(requests))
        return consequence

    def propose(self, moment: Moment) -> Proposal:
        """Propose an order of the queue.

        :raises NotKept: the moment cannot be gone on from
        """
        proposal: Proposal = self._ask('propose', moment, within_s=PROPOSED_WITHIN_S)
        return proposal

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order would be queued.

        :raises NotKept: the moment cannot be gone on from
        """
        checked_order: CheckedOrder = self._ask('check', moment, dict(order))
        return checked_order

    def close(self) -> None:
        """End the process."""
        self._process.close()

    def _ask(self, method: str, moment: Moment, *what: object, within_s: float = WITHIN_S) -> Any:
        try:
            answer = self._process.ask(pickle.dumps((method, moment, what)), within_s)
        except ChildFailed as error:
            raise NotKept(f'nothing could be worked out: {error}') from error
        worked, result = pickle.loads(answer)
        if not worked:
            raise NotKept(f'nothing could be worked out: {result}')
        return result


class _Setup(NamedTuple):
    trees: tuple[Path, ...]
    recipes: tuple[Path, ...]
    any_path: bool


class _Answers:
    """The knowledge of the process: the folders of scripts and recipes, and generated scripts."""

    def __init__(self) -> None:
        self._setup: _Setup | None = None
        self._makers: dict[str, Maker] = {}
        """By the digest of the cell; of the last one only."""

    def __call__(self, question: bytes) -> bytes:
        asked = pickle.loads(question)
        if self._setup is None:
            self._setup = asked
            return b''
        try:
            return pickle.dumps((True, self._answer(*asked)))
        except Exception as error:  # noqa: BLE001 - told to whoever asks
            return pickle.dumps((False, repr(error)))

    def _answer(self, method: str, moment: Moment, what: Sequence[object]) -> object:
        from bt_orchestrator.ros.types.action_types import InstalledActionTypes
        from bt_orchestrator.sim.what_if import EngineWhatIf

        assert self._setup is not None
        trees, folders, any_path = self._setup
        types = InstalledActionTypes()
        make = None if RECIPES.missing else self._maker(moment.cell, types).script
        what_if = EngineWhatIf(moment, types, trees, folders, any_path=any_path, make=make)
        return getattr(what_if, method)(*what)

    def _maker(self, cell: Cell, types: ActionTypes) -> Maker:
        """Return what generates scripts for a cell; it keeps those that it has made."""
        assert self._setup is not None
        name = digest(cell)
        if name not in self._makers:
            self._makers = {name: recipes().maker(cell, types, self._setup.recipes)}
        return self._makers[name]


def main() -> None:
    """Answer until the reader of the answers is gone."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
