"""A cell that answers requests by their names, with scripts that are generated at once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fakes.answers import check_answer
from fakes.line import TYPES, Line, expanded
from fakes.operator import engineer

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.engine.asking.orders import DeskHere
from bt_orchestrator.engine.asking.recipes import RecipeOrders
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.model.requests import CLASSIFY, ask
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.report.account.bookkeeper import has_stop

SCRIPT = """
script: boxes
params: {speed: {type: int, default: 1}}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - repeat:
        - {id: glue, @b2}
        - {id: weigh, @a2, fails_unless: {value: "${results.weigh.measurement}", at_least: 1.0}}
      times: 1
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""

SETUPS = (
    'setups: {nozzle: [fine, wide]}, '
    'changes: {nozzle: {task: TASK_C, argument: special_argument_1}}'
)

REASONS = {
    'JAM': PlantReason('JAM', {'en': 'material jam', 'de': 'Materialstau'}, 'material'),
    'LUNCH': PlantReason('LUNCH', {'en': 'lunch'}),
}

ANN = engineer('Ann', 'golden', 'because')


class RequestBench:
    """A cell whose scale refuses every result, with the answers and records of each request."""

    def __init__(
        self, folder: Path, *, with_setup: bool = False, has_journal: bool = True
    ) -> None:
        """Switch it on.

        :param with_setup: what glues has a setup, and the first change of it fails
        """
        text = SCRIPT.replace('@b2', '@b2, setup: {nozzle: fine}') if with_setup else SCRIPT
        (folder / 'boxes.yaml').write_text(expanded(text))
        line = Line(
            results={'a2': {'measurement': 0.5}},
            keys={'b2': SETUPS} if with_setup else {},
            faults={'b2': 'TASK_C#1=abort'} if with_setup else {},
        )
        self.store = MemoryStore(history='')
        self.sim = Simulation(line.cell, TYPES, self.store)
        state = self.sim.orchestrator.state
        desk = DeskHere(line.cell, TYPES, [folder], state)
        self.handler = RequestHandler(
            self.sim.orchestrator,
            TYPES,
            RecipeOrders(desk, self, state),
            reasons=REASONS,
            stops=self if has_journal else None,
        )
        self.told: list[str] = []

    async def make(
        self, choices: Sequence[RecipeChoice], _: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Generate scripts at once (`ports.Generating`)."""
        text = expanded(SCRIPT) + 'made_from: {recipe: BOX, version: 1, recipe_digest: aa11}\n'
        return [MadeScript('BOX', text.replace('fails_unless', 'retries: 1, fails_unless'))] * len(
            choices
        )

    async def has(self, seq: int) -> bool:
        """Look for a stop at once (`ports.StopSearch`)."""
        return has_stop(MemoryRecords(self.store), seq, self.sim.clock.now(), self.told.append)

    def close(self) -> None:
        """Stop nothing (`ports.Generating`, `ports.StopSearch`)."""

    def pass_time(self, until: float) -> None:
        """Let time pass until nothing more happens, at most to a time."""
        clock = self.sim.clock
        self.sim.orchestrator.settle()
        while (due := clock.next_deadline()) is not None and due <= until:
            clock.advance()
            self.sim.orchestrator.settle()

    def ask(self, name: str, by: By = ANN, **given: Any) -> bool:
        """Make a request, and note what comes of it."""
        before = self.sim.state.seq
        answer = begin(self.handler.carry_out(ask(name, by, **given))).value
        outcome = 'accepted' if answer.accepted else 'refused'
        if name != CLASSIFY.name:  # here a stop has no history to name
            check_answer(answer.message)
        given = {key: value for key, value in given.items() if key != 'orders'}
        self.told.append(f'> {name} {given} by {by.role.value}: {outcome}: {answer.message}')
        self.told += map(to_text, self.store.read(after=before))
        return answer.accepted

    def ask_named(self, name: str, arguments: str = '', by: By = ANN) -> Answer:
        """Make a request that comes as texts."""
        answer = begin(self.handler.carry_out_named(name, arguments, by)).value
        if not answer.accepted:  # else the answer may be of an extension
            check_answer(answer.message)
        return answer

    def records(self, event: str) -> list[Any]:
        """Return the events of a name."""
        return [record for record in self.store.read() if record.event == event]
