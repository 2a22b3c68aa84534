"""A cell whose scripts are generated when a test says so."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fakes.action_types import FakeActionTypes
from fakes.operator import ann
from fakes.script_texts import LINE, cell

from bt_orchestrator.base.errors import NotRead, Refused
from bt_orchestrator.base.replies import Reply, begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import DeskHere
from bt_orchestrator.engine.asking.recipes import RecipeOrders
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event, JobQueued
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
BOX = RecipeChoice(('BOX-7',))
LID = RecipeChoice(('LID-1',), 2, {'glue': 'robot_a'})


def made(version: int = 1, says: str = 'aa11') -> MadeScript:
    origin = f'made_from: {{recipe: BOX-7, version: {version}, recipe_digest: {says}}}\n'
    return MadeScript('BOX-7', LINE + origin)


class Appends(MemoryStore):
    """Notes what was made durable together."""

    def __init__(self) -> None:
        super().__init__()
        self.together: list[list[str]] = []

    def append(self, events: Sequence[Event]) -> None:
        super().append(events)
        jobs = [event.job for event in events if isinstance(event, JobQueued)]
        self.together += [jobs] if jobs else []


class Bench:
    """A cell whose scripts are generated when the test says so. Implements `ports.Generating`."""

    def __init__(self, folder: Path, sim: Simulation | None = None) -> None:
        """Take orders for a cell.

        :param sim: a cell that runs already; None: one that notes what was made durable together
        """
        (folder / 'test.yaml').write_text(LINE)
        self.store = Appends()
        self.sim = sim or Simulation(cell(), TYPES, self.store)
        self.engine: Orchestrator = self.sim.orchestrator
        desk = DeskHere(cell(), TYPES, [folder], self.engine.state)
        orders = RecipeOrders(desk, self, self.engine.state)
        self.handler = RequestHandler(self.engine, TYPES, orders)
        self.asked: list[tuple[tuple[RecipeChoice, ...], frozenset[str]]] = []
        self.replies: list[Reply[object]] = []

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        self.asked.append((tuple(choices), without))
        reply: Reply[object] = Reply()
        self.replies.append(reply)
        outcome = await reply
        if isinstance(outcome, NotRead):
            raise outcome
        assert isinstance(outcome, tuple)
        return outcome

    def close(self) -> None:
        """Nothing works."""

    def give(self, *outcome: MadeScript | Refused) -> None:
        """Say what was generated for the oldest request."""
        self.replies.pop(0).give(outcome)

    def break_down(self) -> None:
        """Let the oldest request for a script end in a defect."""
        self.replies.pop(0).give('no tuple of scripts')

    def order(self, *names: str, recipe: RecipeChoice | None = BOX) -> Reply[Answer]:
        script = '' if recipe else 'test'
        orders = [WorkOrder(script, name, 1, recipe=recipe) for name in names]
        return begin(self.handler.carry_out(ask('queue.add', ann(), orders=orders, held=True)))

    @property
    def queue(self) -> list[str]:
        return [*self.engine.state.jobs]
