"""The records of all requests are byte-equal to those of test/data/requests/*.txt.

`REQUESTS=write` in the environment writes the files anew: a record that changes there changes what
old and new journals say of the same request.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fakes.request_bench import ANN, RequestBench

from bt_orchestrator.model.by import By, Role
from bt_orchestrator.model.jobs.order import RecipeChoice, Terms, WorkOrder
from bt_orchestrator.model.requests import TABLE, About, Kind, Request

DATA = Path(__file__).parents[3] / 'data' / 'requests'


def orders(*names: str, **more: Any) -> list[WorkOrder]:
    return [WorkOrder('boxes', name, 3, {'speed': 2}, Terms(), **more) for name in names]


Step = tuple[str, Mapping[str, Any]] | float

HELD = 12.0
"""Seconds at which the weighing of the first item is held, of a job that has just begun."""


def of_the_queue() -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A', 'B', 'C', 'D'), 'held': True}
    yield 'queue.add', {'orders': orders('E'), 'position': 2}
    yield 'job.move', {'job': 'C', 'position': 1}
    yield 'job.next', {'job': 'D'}
    yield 'job.hold', {'job': 'D'}
    yield 'job.release', {'job': 'A'}
    yield 'job.update', {'job': 'B', 'quantity': 7, 'params': {'speed': 3}, 'priority': 4}
    yield 'job.cancel', {'job': 'B'}
    yield 3.0
    yield 'cell.stop_after_item', {}
    yield 'cell.stop_after_never', {}
    yield 'cell.stop_after_job', {}
    yield 'job.pause', {'job': 'E'}
    yield 'job.resume', {'job': 'E'}
    yield 'job.stop', {'job': 'E'}
    yield 'job.abort', {'job': 'E'}
    yield HELD
    yield 'job.abort', {'job': 'C'}
    yield 'job.clear', {'job': 'C'}


def of_a_proposal() -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A', 'B', 'C'), 'held': True}
    yield 'queue.arrange', {'queue_digest': 'e853b65b8501', 'jobs': ['C', 'A', 'B']}
    yield 'queue.arrange', {'queue_digest': 'e853b65b8501', 'jobs': ['A', 'B', 'C']}


def of_recipes() -> Iterator[Step]:
    yield 'queue.add', {'orders': [WorkOrder('', 'R', 3, {}, recipe=RecipeChoice(('BOX',)))]}
    yield 'script.release_script', {'script': 'boxes'}
    yield 2.0
    yield 'job.requeue', {'job': 'R'}


def of_holds(answer: str, **more: Any) -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A')}
    yield HELD
    yield 'hold.acknowledge', {'hold': '1'}
    yield 'hold.comment', {'hold': '1'}
    yield f'hold.{answer}', {'hold': '1', **more}


def of_a_setup() -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A')}
    yield 5.0
    yield 'hold.skip', {'hold': '1'}
    yield HELD
    yield 'hold.change', {'hold': '2'}


def of_a_first_piece() -> Iterator[Step]:
    terms = Terms(first_piece=True)
    yield 'queue.add', {'orders': [WorkOrder('boxes', 'A', 3, {'speed': 2}, terms)]}
    yield 2.0
    yield 'job.resume', {'job': 'A'}
    yield 'job.another', {'job': 'A'}
    yield 'job.stop', {'job': 'A'}


def of_the_cell() -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A')}
    yield 2.0
    yield 'cell.local', {}
    yield 'cell.remote', {}
    yield 'cell.pause', {}
    yield 'cell.resume', {}
    yield 'cell.pause', {}
    yield 'cell.pause', {}
    yield 'cell.resume', {'hold': '2'}
    yield 'cell.resume', {'everyones': True}
    yield 'component.out_of_service', {'component': 'a2'}
    yield 'component.in_service', {'component': 'a2'}
    yield 'script.release_script', {'script': '0123456789ab'}
    yield 'cell.stop', {}
    yield 'cell.abort', {}
    yield 20.0
    yield 'hold.mark_done', {'hold': '4'}
    yield 'item.remove_item', {'item': 'A/1'}
    yield 'cell.clear', {'belt': ['1=empty', '2=empty', '3=empty']}
    yield 20.0
    yield 'cell.reset', {}
    yield 20.0
    yield 'cell.start', {}


def of_manual() -> Iterator[Step]:
    yield 'component.run_task', {'component': 'a2', 'task': 'TASK_A'}
    yield 'cell.local', {}
    yield 'cell.manual', {}
    yield 'cell.at_panel', {}
    run = {'component': 'a2', 'task': 'TASK_A', 'args': {'special_argument_2': 1.5}}
    yield 'component.run_task', run
    yield 'component.cancel_task', {'component': 'a2'}
    yield 5.0
    yield 'cell.production', {}
    yield 'cell.production', {'belt': ['1=empty', '2=empty', '3=empty']}


def of_reasons() -> Iterator[Step]:
    yield 'queue.add', {'orders': orders('A')}
    yield 'cell.pause', {'code': 'LUNCH'}
    yield 3.0
    yield 'cell.resume', {}
    yield HELD
    yield 'hold.retry', {'hold': '2', 'code': 'TOOTH'}
    yield 'hold.retry', {'hold': '2', 'code': 'JAM'}
    yield 'component.out_of_service', {'component': 'a2', 'code': 'JAM'}
    yield 'component.in_service', {'component': 'a2'}
    yield 'job.pause', {'job': 'A', 'code': 'LUNCH'}
    yield 'job.resume', {'job': 'A'}
    yield 'cell.stop', {'code': 'TOOTH'}
    yield 'cell.stop', {'code': 'LUNCH'}
    yield 'cell.abort', {'code': 'JAM'}
    yield 'cell.abort', {}
    yield 'cell.abort', {'code': 'LUNCH'}
    yield 'stop.classify', {'stop': ':14', 'code': 'JAM'}
    yield 'stop.classify', {'stop': ':41', 'code': 'TOOTH'}
    yield 'stop.classify', {'stop': ':2', 'code': 'JAM'}
    yield 'stop.classify', {'stop': 'abc:41', 'code': 'JAM'}
    yield 'stop.classify', {'stop': '41', 'code': 'JAM'}


STORIES: Mapping[str, Sequence[Step]] = {
    'queue': tuple(of_the_queue()),
    'proposal': tuple(of_a_proposal()),
    'recipes': tuple(of_recipes()),
    'cell': tuple(of_the_cell()),
    **{
        answer: tuple(of_holds(answer))
        for answer in ('retry', 'again', 'skip', 'reject', 'abort_job')
    },
    'change': tuple(of_a_setup()),
    'manual': tuple(of_manual()),
    'reasons': tuple(of_reasons()),
    'first_piece': tuple(of_a_first_piece()),
    'mark_done': tuple(of_holds('mark_done', results={'measurement': 1.5})),
}


def told(folder: Path, steps: Sequence[Step]) -> tuple[str, set[str]]:
    """Return what a story tells, and the requests that were accepted."""
    with_setup = any(step[0] == 'hold.change' for step in steps if not isinstance(step, float))
    cell, accepted = RequestBench(folder, with_setup=with_setup), set[str]()
    for step in steps:
        if isinstance(step, float):
            cell.pass_time(step)
        elif cell.ask(step[0], **step[1]):
            accepted.add(step[0])
    return '\n'.join([*cell.told, '']), accepted


def compare(name: str, text: str) -> None:
    file = DATA / f'{name}.txt'
    if os.environ.get('REQUESTS') == 'write':
        file.write_text(text)
    assert text.splitlines() == file.read_text().splitlines()


@pytest.mark.parametrize('name', STORIES)
def test_records_of_accepted_requests_are_as_they_were(name: str, tmp_path: Path) -> None:
    text, _ = told(tmp_path, STORIES[name])
    compare(name, text)


def test_each_request_is_accepted_in_a_story(tmp_path: Path) -> None:
    accepted = set[str]().union(*(told(tmp_path, steps)[1] for steps in STORIES.values()))
    assert {request.name for request in TABLE} - accepted == set()


OF_KIND = {
    Kind.TEXT: 'none such',
    Kind.WHOLE: 9,
    Kind.TEXTS: ['1=empty'],
    Kind.ORDERS: orders('A'),
}


def needed(request: Request) -> dict[str, Any]:
    given = {param.name: OF_KIND[param.kind] for param in request.parameters if param.is_required}
    return {'as_shown': 1} if request.name == 'cell.clear' else given


def senders(request: Request) -> Iterator[By]:
    yield replace(ANN, role=Role.VIEW)
    yield replace(ANN, reason=' ')
    if request.about is not About.CELL:
        yield ANN


def test_records_of_refused_requests_are_as_they_were(tmp_path: Path) -> None:
    """Each request comes without the role, without a reason, and about nothing that exists."""
    text = ''
    for request in TABLE:
        cell = RequestBench(tmp_path)
        for by in senders(request):
            cell.ask(request.name, by, **needed(request))
        text += '\n'.join([*cell.told, ''])
    compare('refused', text)
