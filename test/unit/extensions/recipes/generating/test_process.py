"""Scripts generated in another process: whatever becomes of it, each request is answered."""

from __future__ import annotations

import pickle
import queue
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.glue_cell import CELL, RECIPE

from bt_orchestrator.base.child_process import ChildFailed, ChildTooLate
from bt_orchestrator.base.errors import NotRead, Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.extensions.recipes.generating import process as module
from bt_orchestrator.extensions.recipes.generating.ordered import RecipeMaker
from bt_orchestrator.extensions.recipes.generating.process import (
    BUSY,
    LATE,
    MOST_WAITING,
    GeneratingProcess,
)
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.ports import MadeScript
from bt_orchestrator.script.cell_file import parse_cell

LONGEST_S = 40.0
TYPES = FakeActionTypes()


class ProcessInHere:
    """Answers with what the process would, or fails as it is told to."""

    def __init__(self, _: str, setup: bytes) -> None:
        self._answers = module._Answers.__new__(module._Answers)
        self._answers._types = TYPES  # type: ignore[assignment]
        self._answers._begin = RecipeMaker
        self._answers._maker = None
        assert self._answers(setup) == b''
        self.failures: list[Exception] = []

    def ask(self, data: bytes, within_s: float) -> bytes:
        assert within_s > 0
        if self.failures:
            raise self.failures.pop(0)
        return self._answers(data)

    def close(self) -> None:
        """Nothing is left."""


class Bench:
    def __init__(self, folder: Path) -> None:
        (folder / 'box.yaml').write_text(RECIPE)
        self.turns: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        cell = parse_cell(CELL, 'cell', TYPES)
        self.generating = GeneratingProcess(cell, [folder], self.turns.put)
        self.said: list[object] = []

    @property
    def process(self) -> ProcessInHere:
        process: object = self.generating._process
        assert isinstance(process, ProcessInHere)
        return process

    def ask(self, *names: str) -> None:
        begin(self._steps(*names))

    async def _steps(self, *names: str) -> None:
        choices = [RecipeChoice((name,)) for name in names]
        try:
            made = await self.generating.make(choices, frozenset())
            self.said.append([type(result) for result in made])
        except NotRead as why:
            self.said.append(str(why))

    def turn(self, times: int = 1) -> None:
        for _ in range(times):
            self.turns.get(timeout=LONGEST_S)()


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setattr(module, 'ChildProcess', ProcessInHere)
    made = Bench(tmp_path)
    yield made
    made.generating.close()


def test_requests_are_answered_in_order_by_asking_thread(bench: Bench) -> None:
    bench.ask('BOX-7', 'BOX-8')
    bench.ask('BOX-7')
    assert bench.said == []
    bench.turn(2)
    assert bench.said == [[MadeScript, Refused], [MadeScript]]


def test_failure_is_reported_and_next_script_is_made(bench: Bench) -> None:
    bench.process.failures = [
        ChildTooLate('no answer'),
        ChildFailed('it ended by SIGKILL'),
        MemoryError(),
    ]
    for _ in range(4):
        bench.ask('BOX-7')
    bench.turn(4)
    late, failed, unforeseen, made = bench.said
    assert late == LATE
    assert str(failed).startswith('no script can be generated now: it ended by SIGKILL; ')
    assert str(unforeseen).startswith('no script can be generated now: MemoryError(); ')
    assert made == [MadeScript]


def test_a_defect_is_told_as_one(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError('planned wrong')

    monkeypatch.setattr(RecipeMaker, 'script', broken)
    bench.ask('BOX-7')
    bench.turn()
    (answer,) = bench.said
    assert "defect of the orchestrator: ZeroDivisionError('planned wrong')" in str(answer)


def test_too_many_requests_are_refused_at_once(bench: Bench) -> None:
    for _ in range(MOST_WAITING + 1):
        bench.ask('BOX-8')
    assert bench.said == [BUSY]
    bench.turn(MOST_WAITING)
    assert len(bench.said) == MOST_WAITING + 1


def test_an_answer_is_what_goes_between_two_processes(bench: Bench) -> None:
    question = pickle.dumps(((RecipeChoice(('BOX-7',)),), frozenset({'robot_a'})))
    (made,) = pickle.loads(bench.process.ask(question, 1.0))
    assert isinstance(made, MadeScript)
    assert 'without robot_a' in made.text or 'robot_a' not in made.text.split('sections:')[1]
