"""One answer for several holds: each is sent and recorded by itself, or none is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from contract.link_bench import Seen
from fakes.line import Line, expanded, with_section
from fakes.operator import engineer

from bt_orchestrator.cli.door import instead_of_a_door
from bt_orchestrator.cli.main import main
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.advice import Shell

SCRIPT = with_section(2, '- parallel: [{id: look, @a2}, {id: mark, @b2}]')


class TrustingLink(VirtualLink):
    """A link of somebody whose name is known."""

    def ask(self, asked: Asked) -> Answer:
        return super().ask(replace(asked, by=engineer('Ann', reason=asked.sender.reason)))


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def link(tmp_path: Path, store: MemoryStore) -> Iterator[VirtualLink]:
    """A cell with two tasks in doubt, and a third that aborted while it placed an item."""
    line = Line(faults={'a2': '#1=cancel', 'b2': '#1=cancel', 'a1': '#2=abort'})
    (tmp_path / 'test.yaml').write_text(expanded(f'script: test\n{SCRIPT}'))
    node = VirtualNode(line.cell, line.types, [tmp_path])
    node.switch_on(store)
    link = TrustingLink(node)
    link.follow(Seen(), 0)
    add = ask('queue.add', engineer('Ann'), orders=[WorkOrder('test', 'J', 3)])
    assert link.ask(add).accepted
    link.turn(20.0)
    held = {hold.id: (hold.task, hold.reason) for hold in link.status().holds}
    assert {held[n] for n in held} == {
        ('look', 'in_doubt'),
        ('mark', 'in_doubt'),
        ('place', 'aborted'),
    }
    with instead_of_a_door(nullcontext(link)):
        yield link


def ids(link: VirtualLink, *tasks: str) -> str:
    return ','.join(hold.id for hold in link.status().holds if hold.task in tasks)


def decided(store: MemoryStore) -> list[tuple[str, str]]:
    made = (event for event in store.read() if isinstance(event, e.OperatorDecided))
    return [(event.answer, event.reason) for event in made if event.reason == 'looked']


def test_each_answer_of_list_has_own_record(
    link: VirtualLink, store: MemoryStore, capsys: pytest.CaptureFixture[str]
) -> None:
    both = ids(link, 'look', 'mark')
    assert main(['answer', both, 'mark_done', '--reason', 'looked']) == 0
    assert [line.partition(':')[0] for line in capsys.readouterr().out.splitlines()] == [
        f'hold {hold_id}' for hold_id in both.split(',')
    ]
    assert decided(store) == [('mark_done', 'looked')] * 2
    assert [hold.task for hold in link.status().holds] == ['place']


@pytest.mark.parametrize(
    ('tasks', 'answer', 'message'),
    [
        (('look', 'mark', 'place'), 'mark_done', 'answer it singly'),
        (('look', 'mark'), 'retry', 'a list can answer it with mark_done, skip, reject'),
    ],
)
def test_invalid_answer_list_is_refused_whole(
    link: VirtualLink,
    store: MemoryStore,
    capsys: pytest.CaptureFixture[str],
    tasks: tuple[str, ...],
    answer: str,
    message: str,
) -> None:
    assert main(['answer', ids(link, *tasks), answer, '--reason', 'looked']) == 1
    errors = capsys.readouterr().err
    assert message in errors
    assert errors.endswith('nothing was answered\n')
    assert decided(store) == []
    assert len(link.status().holds) == 3


def test_a_status_says_which_list_can_be_typed(link: VirtualLink) -> None:
    both = ids(link, 'look', 'mark')
    (line,) = [text for text in words.status_lines(link.status(), Shell()) if 'alike:' in text]
    assert f'bt-orchestrator answer {both} mark_done --reason "WHY" (or skip, reject)' in line
