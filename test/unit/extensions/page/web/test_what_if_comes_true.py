"""What the page says before a change of the queue is what a run of the changed queue comes to."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest
from contract.link_bench import Seen
from fakes.line import THREE, Line, expanded
from fakes.operator import engineer

from bt_orchestrator.extensions.page.web.planning.questions import Questions, asked_of
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.ports import CheckedOrder, Consequence, Moment, Proposal
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.sim.what_if import EngineWhatIf
from bt_orchestrator.store.memory import MemoryStore

QUANTITIES = {'A': 2, 'B': 3, 'C': 1, 'D': 2}


class PlanningHere:
    """Implements `ports.Planning` without another process."""

    def __init__(self, line: Line) -> None:
        self._types = line.types

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        return EngineWhatIf(moment, self._types).ask(requests)

    def propose(self, moment: Moment) -> Proposal:
        return EngineWhatIf(moment, self._types).propose()

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        return EngineWhatIf(moment, self._types).check(order)

    def close(self) -> None:
        """Do nothing: there is no process."""


class Cell:
    """A line with four jobs, the first of them at work."""

    def __init__(self, folder: Path) -> None:
        line = Line(3, seconds={'a2': 4.0})
        (folder / 'test.yaml').write_text(expanded(f'script: test\n{THREE}'))
        node = VirtualNode(line.cell, line.types, [folder])
        node.switch_on(MemoryStore())
        self.link = VirtualLink(node)
        self.seen = Seen()
        self.link.follow(self.seen, 0)
        orders = [WorkOrder('test', job, quantity) for job, quantity in QUANTITIES.items()]
        assert self.ask('queue.add', orders=orders)
        self.link.turn(3.0)
        self.questions = Questions(PlanningHere(line), self._moment)

    async def _moment(self) -> Moment:
        return self.link.moment()

    def ask(self, name: str, **arguments: Any) -> bool:
        return self.link.ask(ask(name, engineer('Ann'), **arguments)).accepted

    def predicted(self, *commands: tuple[str, dict[str, object]]) -> dict[str, Any]:
        """Return what the page answers."""
        asked = [asked_of({'name': name, 'arguments': given}) for name, given in commands]

        async def is_gone() -> bool:
            return False

        return asyncio.run(self.questions.what_if(asked, len(QUANTITIES) - 1, is_gone))

    def ends(self) -> dict[str, float]:
        """Let everything be made; returns when each job really ended."""
        for _ in range(1000):
            done = self.seen.of('job.completed')
            if len(done) == len(QUANTITIES):
                return {vars(event)['job']: event.time for event in done}
            self.link.turn(1.0)
        raise AssertionError('the jobs do not end')


CHANGES: list[list[tuple[str, dict[str, object]]]] = [
    [('job.next', {'job': 'D'})],
    [('job.move', {'job': 'B', 'position': 3})],
    [('job.move', {'job': 'D', 'position': 1}), ('job.update', {'job': 'B', 'quantity': 1})],
]


@pytest.mark.parametrize('change', CHANGES)
def test_predicted_ends_match_real_runs(
    tmp_path: Path, change: list[tuple[str, dict[str, object]]]
) -> None:
    cell = Cell(tmp_path)
    prediction = cell.predicted(*change)
    assert prediction['refusals'] == []
    assert _ends(prediction['before']) == pytest.approx(Cell(tmp_path).ends())
    for name, given in change:
        assert cell.ask(name, **given)
    ends = cell.ends()
    assert _ends(prediction['after']) == pytest.approx(ends)
    assert ends != pytest.approx(_ends(prediction['before'])), 'the change makes a difference'


def _ends(jobs: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    return {job['job']: job['ends'] for job in jobs}
