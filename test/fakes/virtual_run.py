"""One virtual run, what happened in it, and the checks that hold for every run."""

from __future__ import annotations

import json
from collections.abc import Callable, Container
from typing import Any

from fakes.answers import check_answer
from fakes.board import check_board, tidy_after
from fakes.commands import (
    AnswerHold,
    CellCommand,
    ControlJob,
    Pause,
    ReleaseScript,
    RemoveItem,
    Resume,
    SetService,
)
from fakes.full_tree import check_view
from fakes.invariants import Invariants
from fakes.operator import ann, engineer
from fakes.told_waits import ToldWaits, told_of
from fakes.tree_waits import waits_of

from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest, from_record, to_record
from bt_orchestrator.model.commands import Answer, Command, RefusedRequest
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.waits.waiting import (
    of_belt,
    of_initialization,
    of_item,
    of_section,
    together,
)
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryStore

BY = engineer('Ann', 'the test', 'it was time')

MOST_SETTLES_AT_ONCE = 1000
"""A line that settles more often than this without time going on never ends."""


class VirtualRun:
    """A line at work. Every step forward is checked against `Invariants` and a replay.

    The replay follows the run: an event that is equal to its record read back changes a state in
    the same way, so that every prefix of the records tells the state of its moment.
    """

    def __init__(
        self,
        cell: Cell,
        types: ActionTypes,
        *,
        rebuild: Container[int] = (),
        duration: Callable[[GoalRequest], float] | None = None,
        viewed: bool = False,
        auto_start: bool = True,
    ) -> None:
        """Switch the line on.

        :param duration: seconds of each goal; without it the nominal ones
        :param rebuild: numbers of the settles after which the tree is compiled anew
        :param viewed: compare the tree after every settle with one that is compiled anew
        """
        self._viewed = viewed
        self.store = MemoryStore(history='')  # nothing random
        self.sim = Simulation(cell, types, self.store, duration=duration, auto_start=auto_start)
        tidy_after(self.sim.orchestrator)
        self._invariants = Invariants(cell)
        self._replay = CellState(cell)
        self._rebuild = rebuild
        self._settles = 0
        self._records: list[dict[str, Any]] = []
        self.told_waits: dict[float, ToldWaits] = {}
        """What was told of each item after the last settle of each moment."""

    # --- going on ---------------------------------------------------------------------------

    def submit(self, job: str, script: Script, quantity: int = 1, **params: object) -> Answer:
        """Queue a job now."""
        return self.ask(AddJobs((Job(job, script, quantity, defaults(script) | params),)))

    def go(self, until: float = 1e6) -> VirtualRun:
        """Let time pass until nothing more can happen, at most to a time."""
        orchestrator, clock = self.sim.orchestrator, self.sim.clock
        orchestrator.settle()
        here = 0
        while self.sim.state.jobs:
            due = clock.next_deadline()
            if due is None or due > until:
                break
            here = here + 1 if due == clock.now() else 0
            assert here < MOST_SETTLES_AT_ONCE, f'time stands still at {due!r}'
            clock.advance()
            orchestrator.settle()
            self.check_reasons()
            self._after_settle()
            self._check()
        self._check()
        self._check_messages()
        return self

    def _check_messages(self) -> None:
        """Check that the facts of each hold's message say what the message says."""
        for hold in self.state.holds.values():
            sentences = '; '.join(words.text() for words in hold.message_words)
            assert sentences in ('', hold.message), f'hold {hold.id}'

    def ask(self, command: Command) -> Answer:
        """Give a command now; everything due at this moment has happened."""
        answer = self.sim.orchestrator.ask(command)
        if not isinstance(command, RefusedRequest):
            check_answer(answer.message)
        self._after_settle()
        self._check()
        return answer

    def add(
        self, *jobs: tuple[str, Script], position: int | None = None, held: bool = False
    ) -> Answer:
        """Queue jobs of one item each now, all or none."""
        orders = tuple(Job(name, script, 1, {}) for name, script in jobs)
        return self.ask(AddJobs(orders, BY, position, held))

    def control(self, verb: str, job: str) -> Answer:
        """Ask something of a job now."""
        return self.ask(ControlJob(verb, job, BY))

    def answer(self, answer: str, hold: str | None = None) -> Answer:
        """Answer a hold, the only one unless named; the operator is Ann."""
        if hold is None:
            (hold,) = self.state.holds
        return self.ask(AnswerHold(hold, answer, ann('it looked so')))

    def command(self, kind: CellCommand, who: str = 'Ann', **more: Any) -> Answer:
        """Give a command to the cell."""
        return self.ask(kind(engineer(who), **more))

    @property
    def states(self) -> list[str]:
        """The states that the cell went through."""
        return self.order('cell.state_changed', 'state')

    def remove(self, item: str) -> Answer:
        """Take an item off the belt by hand."""
        return self.ask(RemoveItem(item, ann('it fell over')))

    def pause(self) -> Answer:
        """Let the cell start nothing more."""
        return self.ask(Pause(ann('coffee')))

    def resume(self) -> Answer:
        """Let it go on."""
        return self.ask(Resume(ann('back')))

    def service(self, component: str, *, out: bool) -> Answer:
        """Take a component out of service, or bring it back."""
        return self.ask(SetService(component, not out, ann('worn')))

    def release(self, script: Script) -> Answer:
        """Release a script for this cell."""
        return self.ask(ReleaseScript(digest(script), engineer('Eve', reason='read it')))

    # --- looking ----------------------------------------------------------------------------

    @property
    def now(self) -> float:
        return self.sim.clock.now()

    @property
    def state(self) -> CellState:
        return self.sim.state

    @property
    def ended(self) -> bool:
        """Tell whether no job is live any more."""
        return not self.state.jobs

    def job(self, name: str = 'J') -> JobState:
        """Return a job, live or ended."""
        return self.state.jobs.get(name) or self.state.ended[name]

    @property
    def records(self) -> list[dict[str, Any]]:
        """Everything that happened, as records."""
        return [*self._made()]

    def all(self, event: str, **fields: object) -> list[dict[str, Any]]:
        """Return the records of one event, of those fields."""
        return [
            record
            for record in self._made()
            if record['event'] == event
            and all(record.get(name) == value for name, value in fields.items())
        ]

    def times(self, event: str, **fields: object) -> list[float]:
        """Return when an event happened."""
        return [record['time'] for record in self.all(event, **fields)]

    def starts(self, task: str, **fields: object) -> list[float]:
        """Return when the attempts of a task began."""
        return self.times('task.started', task=task, **fields)

    def order(self, event: str, field: str = 'task') -> list[str]:
        """Return one field of an event, in the order of happening."""
        return [record[field] for record in self.all(event)]

    def reasons(self) -> list[str]:
        """Return why attempts failed."""
        return self.order('task.failed', 'reason')

    def waits(self) -> dict[str, str]:
        """Return what each part of the cell waits for now."""
        reasons: dict[str, str] = {}
        for wait in self.sim.waits():
            before = reasons.get(wait.part)
            reasons[wait.part] = wait.reason if before is None else f'{before}; {wait.reason}'
        return reasons

    def counts(self, name: str = 'J') -> dict[str, int]:
        """Return a job's counts that are not 0 (semantics 6.2)."""
        return {key: count for key, count in vars(self.job(name).progress).items() if count}

    def _made(self) -> list[dict[str, Any]]:
        """Return all records, which are asked for often, and made once."""
        self._records += map(to_record, self.store.read(len(self._records)))
        return self._records

    # --- checking ---------------------------------------------------------------------------

    def _after_settle(self) -> None:
        if self._viewed:
            check_view(self.sim.orchestrator)
        self._settles += 1
        if self._settles in self._rebuild:
            orchestrator = self.sim.orchestrator
            orchestrator.tree.close()
            space = orchestrator._projection.space
            orchestrator.tree = CellTree(orchestrator._ledger, space)
            orchestrator._ledger._noticing.clear()

    def check_reasons(self) -> None:
        """Whoever does not work says why (semantics 7.4)."""
        waits, seen = self.waits(), self.sim.orchestrator.tree.recorder
        for item in self.state.items.values():
            if item.section and not self.state.indexing:
                has_goal = any(key.item == item.id for key in self.state.running)
                assert has_goal or any(of_item(self.state, item, seen)), (item.id, self.now)
        working = {key.section for key in self.state.running}
        for number in self.state.sections:
            assert number in working or waits.get(f'section {number}'), (number, self.now)
        assert self.state.indexing or waits.get('belt'), self.now

        self._check_tree()

    def _check_tree(self) -> None:
        """What is told of waits is what keeps the behaviours of the tree from going on."""
        tree, state, seen = (
            self.sim.orchestrator.tree,
            self.state,
            self.sim.orchestrator.tree.recorder,
        )
        pairs = [
            (tree.initialization, of_initialization(state, seen)),
            *(
                (tree.sections[n], of_section(state, section, seen))
                for n, section in state.sections.items()
            ),
            (tree.belt, of_belt(state, seen)),
        ]
        for part, waiting in pairs:
            view = tuple(dict.fromkeys(changed(wait, components=()) for wait in together(waiting)))
            assert view == waits_of(part), (part.name, self.now)

    def _check(self) -> None:
        check_board(self.sim.orchestrator._projection.space, self.state)
        before = self._replay.seq
        for event, record in zip(self.store.read(before), self._made()[before:], strict=True):
            read = from_record(json.loads(json.dumps(record)))
            assert read == event
            self._invariants.follow(event)
            apply(self._replay, read)
        assert snapshot(self._replay) == snapshot(self.state)
        self.told_waits[self.now] = {
            item.id: told_of(self.state, item, self.sim.orchestrator.tree.recorder)
            for item in self.state.items.values()
        }


def defaults(script: Script) -> dict[str, Any]:
    """Return the parameters of an order that names none."""
    return {name: parameter.default for name, parameter in script.params.items()}


def snapshot(state: CellState) -> dict[str, Any]:
    """Return what a state holds, to be compared."""
    plain = {name: value for name, value in vars(state).items() if name != 'cell'}
    plain['preparations'] = sorted(state.preparations)
    return plain
