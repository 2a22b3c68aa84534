"""Orders read apart from the line, and what goes between the two."""

from __future__ import annotations

import json
import pickle
from functools import cached_property
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import LINE, cell

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.codec import digest, to_text
from bt_orchestrator.model.events import ScriptLoaded
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.orders.desk import (
    AskedOrder,
    ChangedJob,
    OrderDesk,
    Orders,
    Question,
    Wanted,
    WrittenOrder,
)
from bt_orchestrator.script.orders.desk_pickles import pickled, unpickled

TEXT = LINE + 'params: {lot: {type: str, default: none}}\n'
IDS = ('WO-1', 'WO-2', 'WO-3')


@pytest.fixture
def desk(tmp_path: Path) -> OrderDesk:
    (tmp_path / 'test.yaml').write_text(TEXT)
    return OrderDesk(cell(), FakeActionTypes(), [tmp_path], any_path=False)


def jobs(desk: OrderDesk, wanted: Wanted, **known: object) -> list[Job | Refused]:
    question = Question(wanted, IDS, **known)  # type: ignore[arg-type]
    return list(desk.answer(pickle.loads(pickle.dumps(question))).read)


def job(desk: OrderDesk, wanted: Wanted, **known: object) -> Job:
    (one,) = jobs(desk, wanted, **known)
    assert isinstance(one, Job), one
    return one


def order(**fields: object) -> Orders:
    return Orders((AskedOrder('test', **fields),))  # type: ignore[arg-type]


def test_orders_become_jobs_and_those_without_an_id_get_the_free_ones(desk: OrderDesk) -> None:
    wanted = Orders(
        (
            AskedOrder('test', quantity=2),
            AskedOrder('test', 'mine', 1, {'lot': 'A7'}),
            AskedOrder('test', quantity=3),
        )
    )
    read = [one for one in jobs(desk, wanted) if isinstance(one, Job)]
    assert [(one.id, one.quantity, one.params) for one in read] == [
        ('WO-1', 2, {'lot': 'none'}),
        ('mine', 1, {'lot': 'A7'}),
        ('WO-2', 3, {'lot': 'none'}),
    ]
    assert len({id(one.script) for one in read}) == 1


def test_a_script_is_read_once_as_long_as_its_text_is_the_same(
    desk: OrderDesk, tmp_path: Path
) -> None:
    first, second = (job(desk, order(quantity=1)).script for _ in range(2))
    assert first is second

    (tmp_path / 'test.yaml').write_text(TEXT + 'quantity: 7\n')
    assert job(desk, order()).quantity == 7
    (tmp_path / 'test.yaml').write_text('script: test\n')
    (refused,) = jobs(desk, order(quantity=1))
    assert isinstance(refused, Refused)
    (tmp_path / 'test.yaml').write_text(TEXT)
    assert job(desk, order(quantity=1)).script is first


def test_a_written_order_has_its_mistakes_and_those_of_its_script(desk: OrderDesk) -> None:
    assert job(desk, WrittenOrder('script: test\nquantity: 2\n')).id == 'WO-1'
    (refused,) = jobs(desk, WrittenOrder('script: missing\nquantity: none\n'))
    assert isinstance(refused, Refused)
    assert len(refused.findings) == 2
    assert pickle.loads(pickle.dumps(refused)).findings == refused.findings


def test_a_job_is_changed_as_it_was_read(desk: OrderDesk, tmp_path: Path) -> None:
    queued = job(desk, order(quantity=5, params={'lot': 'A'}))
    name = digest(queued.script)
    (tmp_path / 'test.yaml').unlink()
    change = ChangedJob('WO-1', name, 5, {'lot': 'A'}, AskedOrder('', quantity=6))
    changed = job(desk, change, scripts={name: pickle.dumps(queued.script)})
    assert (changed.id, changed.quantity, changed.params) == ('WO-1', 6, {'lot': 'A'})


def test_a_script_that_is_there_already_is_not_sent_and_stays_one_object(desk: OrderDesk) -> None:
    reading = desk.answer(Question(order(quantity=1), IDS))
    whole = pickled(reading, frozenset())
    (first,) = unpickled(whole, {}).read
    here = {digest(first.script): first.script}
    short = pickled(reading, here.keys())
    (second,) = unpickled(short, here).read
    assert second == first
    assert second.script is first.script
    assert len(short) < len(whole) / 3


def test_what_is_asked_of_a_script_is_worked_out_where_it_is_read(
    desk: OrderDesk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its name and its text take a second for 10,000 tasks: not in the thread that ticks."""
    (one,) = unpickled(
        pickled(desk.answer(Question(order(quantity=1), IDS)), frozenset()), {}
    ).read

    def never(_: object) -> None:
        raise AssertionError('a script is written anew')

    monkeypatch.setattr('bt_orchestrator.model.codec.to_plain', never)
    assert json.loads(to_text(loaded(one.script)))['definition']['name'] == 'test'
    known = {name for name, member in vars(Script).items() if isinstance(member, cached_property)}
    assert known
    assert known <= vars(one.script).keys()


def loaded(script: Script) -> ScriptLoaded:
    return ScriptLoaded(script=script.name, digest=digest(script), definition=script)


def test_scripts_that_disagree_about_a_flag_are_told_apart(
    desk: OrderDesk, tmp_path: Path
) -> None:
    def flagged(capacity: int) -> str:
        flag = f'{{flag: f, upstream: place, downstream: pack, capacity: {capacity}}}'
        return f'{TEXT}lateral_dependencies: [{flag}]\n'

    (tmp_path / 'test.yaml').write_text(flagged(3))
    live = job(desk, order(quantity=1)).script
    (tmp_path / 'test.yaml').write_text(flagged(4))
    question = Question(order(quantity=1), IDS, (digest(live),), _sent(live))
    reading = desk.answer(question)
    (new,) = reading.read
    assert isinstance(new, Job)
    assert reading.sharing.among == {digest(live), digest(new.script)}
    assert 'share the flag f but disagree' in reading.sharing.why_not[digest(new.script)]


def _sent(script: Script) -> dict[str, bytes]:
    return {digest(script): pickle.dumps(script)}
