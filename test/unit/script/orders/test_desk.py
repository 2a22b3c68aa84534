"""Orders read apart from the line, and what goes between the two."""

from __future__ import annotations

import json
import pickle
import re
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import LINE, cell

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.codec import digest, to_text
from bt_orchestrator.model.events import ScriptLoaded
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.script import MadeFrom, Script
from bt_orchestrator.script.orders.desk import (
    AskedOrder,
    ChangedJob,
    OrderDesk,
    Orders,
    Question,
    Wanted,
    WrittenOrder,
)
from bt_orchestrator.script.orders.desk_pickles import name_of, pickled, unpickled
from bt_orchestrator.script.orders.terms import AskedTerms

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
    (result,) = jobs(desk, wanted, **known)
    assert isinstance(result, Job), result
    return result


def order(**fields: object) -> Orders:
    return Orders((AskedOrder('test', **fields),))  # type: ignore[arg-type]


def test_orders_without_ids_become_jobs_with_free_ids(desk: OrderDesk) -> None:
    wanted = Orders(
        (
            AskedOrder('test', quantity=2),
            AskedOrder('test', 'mine', 1, {'lot': 'A7'}),
            AskedOrder('test', quantity=3),
        )
    )
    read = [new_job for new_job in jobs(desk, wanted) if isinstance(new_job, Job)]
    assert [(new_job.id, new_job.quantity, new_job.params) for new_job in read] == [
        ('WO-1', 2, {'lot': 'none'}),
        ('mine', 1, {'lot': 'A7'}),
        ('WO-2', 3, {'lot': 'none'}),
    ]
    assert len({id(new_job.script) for new_job in read}) == 1


def test_unchanged_script_text_is_read_only_once(desk: OrderDesk, tmp_path: Path) -> None:
    first, second = (job(desk, order(quantity=1)).script for _ in range(2))
    assert first is second

    (tmp_path / 'test.yaml').write_text(TEXT + 'quantity: 7\n')
    assert job(desk, order()).quantity == 7
    (tmp_path / 'test.yaml').write_text('script: test\n')
    (refused,) = jobs(desk, order(quantity=1))
    assert isinstance(refused, Refused)
    (tmp_path / 'test.yaml').write_text(TEXT)
    assert job(desk, order(quantity=1)).script is first


def test_written_order_reports_mistakes_of_order_and_script(desk: OrderDesk) -> None:
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


def test_excessive_quantity_is_refused_except_in_old_jobs(desk: OrderDesk) -> None:
    for request in (order(quantity=10**9), WrittenOrder('script: test\nquantity: 10001\n')):
        (refused,) = jobs(desk, request)
        assert isinstance(refused, Refused)
        assert 'at most 10000 items' in str(refused)
    queued = job(desk, order(quantity=5, params={'lot': 'A'}))
    name = digest(queued.script)
    scripts = {name: pickle.dumps(queued.script)}
    wish = AskedOrder('', terms=AskedTerms(priority=2))
    changed = job(desk, ChangedJob('<old>', name, 20_000, {'lot': 'A'}, wish), scripts=scripts)
    assert (changed.id, changed.quantity) == ('<old>', 20_000)
    wish = AskedOrder('', quantity=20_001)
    (refused,) = jobs(desk, ChangedJob('WO-1', name, 20_000, {'lot': 'A'}, wish), scripts=scripts)
    assert isinstance(refused, Refused)


TERMS = Terms(5, 1779084000.0, 1779090000.5, {'customer': {'$': ['ACME']}})


def asked(terms: Terms) -> AskedTerms:
    """Return what a client says that wants all of it."""
    return AskedTerms(
        terms.priority, terms.start or 0.0, terms.due or 0.0, json.dumps(terms.details)
    )


def test_priority_times_and_details_go_into_the_job(desk: OrderDesk) -> None:
    assert job(desk, order(quantity=1, terms=asked(TERMS))).terms == TERMS
    assert job(desk, order(quantity=1)).terms == Terms()
    text = (
        'script: test\nquantity: 1\npriority: 5\nstart: 2026-05-18T06:00:00Z\n'
        'due: 2026-05-18T09:40:00.5+02:00\ndetails: {customer: {$: [ACME]}}\n'
    )
    assert job(desk, WrittenOrder(text)).terms == TERMS


@pytest.mark.parametrize(
    ('wish', 'expected'),
    [
        (AskedTerms(), TERMS),
        (AskedTerms(priority=0), replace(TERMS, priority=0)),
        (AskedTerms(start=0.0), replace(TERMS, start=None)),
        (AskedTerms(due=0.0), replace(TERMS, due=None)),
        (AskedTerms(due=1779084000.0), replace(TERMS, due=1779084000.0)),
        (AskedTerms(details='{}'), replace(TERMS, details={})),
        (AskedTerms(details='{"a": 1}'), replace(TERMS, details={'a': 1})),
    ],
)
def test_a_change_keeps_what_it_does_not_say(
    desk: OrderDesk, wish: AskedTerms, expected: Terms
) -> None:
    queued = job(desk, order(quantity=1, terms=asked(TERMS)))
    name = digest(queued.script)
    change = ChangedJob('WO-1', name, 1, {}, AskedOrder('', terms=wish), queued.terms)
    assert job(desk, change, scripts={name: pickle.dumps(queued.script)}).terms == expected


@pytest.mark.parametrize(
    ('terms', 'message'),
    [
        (AskedTerms(priority=2**15), '`priority` must be at most 32767, not the number 32768'),
        (AskedTerms(start=-1.0), '`start` must be between 1970 and 2038'),
        (AskedTerms(due=2.0**31), '`due` must be between 1970 and 2038'),
        (AskedTerms(start=20.0, due=10.0), '`due` lies before `start`'),
        (AskedTerms(details='{'), '`details` must be JSON: Expecting property name'),
        (AskedTerms(details='[1]'), '`details` must be a JSON object, not a list'),
        (AskedTerms(details='[' * 100_000), '`details` must be JSON: it is nested too deep'),
        (AskedTerms(details='{"a": [' + '9' * 5000 + ']}'), '`details` must '),
        (AskedTerms(details='{"a": NaN}'), '`details` must have finite numbers'),
        (AskedTerms(details='{"a": 1e999}'), '`details` must have finite numbers'),
        (AskedTerms(details=json.dumps({'a': 'ü' * 4000})), 'at most 8000 bytes as JSON, and not'),
    ],
)
def test_unstorable_terms_are_reported_beside_other_findings(
    desk: OrderDesk, terms: AskedTerms, message: str
) -> None:
    (refused,) = jobs(desk, order(order='A', terms=terms))
    assert isinstance(refused, Refused)
    first, second = sorted(map(str, refused.findings), key=lambda text: message not in text)
    assert re.match(r'order A, (\w+):1:1: `\1` ', first)
    assert message in first
    assert 'the order names no quantity' in second


def test_details_of_the_largest_size_are_kept(desk: OrderDesk) -> None:
    details = {'a': 'x' * (8_000 - len('{"a": ""}'))}
    terms = AskedTerms(details=json.dumps(details))
    assert job(desk, order(quantity=1, terms=terms)).terms.details == details


def test_known_script_is_not_resent_and_stays_identical(desk: OrderDesk) -> None:
    reading = desk.answer(Question(order(quantity=1), IDS))
    whole = pickled(reading, frozenset())
    (first,) = unpickled(whole, {}).read
    here = {name_of(first.script): first.script}
    short = pickled(reading, here.keys())
    (second,) = unpickled(short, here).read
    assert second == first
    assert second.script is first.script
    assert len(short) < len(whole) / 3
    other = replace(first.script, made_from=MadeFrom('BOX-7', 2))
    assert digest(other) == digest(first.script)
    again = pickled(replace(reading, read=(replace(first, script=other),)), here.keys())
    (third,) = unpickled(again, here).read
    assert third.script.made_from == MadeFrom('BOX-7', 2)


def test_script_properties_are_computed_where_it_is_read(
    desk: OrderDesk, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its name and its text take a second for 10,000 tasks: not in the thread that ticks."""
    (new_job,) = unpickled(
        pickled(desk.answer(Question(order(quantity=1), IDS)), frozenset()), {}
    ).read

    def never(_: object) -> None:
        raise AssertionError('a script is written anew')

    monkeypatch.setattr('bt_orchestrator.model.codec.to_plain', never)
    assert json.loads(to_text(loaded(new_job.script)))['definition']['name'] == 'test'
    known = {name for name, member in vars(Script).items() if isinstance(member, cached_property)}
    assert known
    assert known <= vars(new_job.script).keys()


def loaded(script: Script) -> ScriptLoaded:
    return ScriptLoaded(script=script.name, digest=digest(script), definition=script)


def test_scripts_with_conflicting_flags_are_distinguished(desk: OrderDesk, tmp_path: Path) -> None:
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
