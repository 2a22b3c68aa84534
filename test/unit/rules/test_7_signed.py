"""Semantics 7.12: a signature says who asks, at which node, when, and counts once."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from fakes.line import Line
from fakes.signing import SignedBench, signed, user_of_door

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.by import By, Known, Role, Signed
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.commands import RefusedRequest
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain
from bt_orchestrator.model.limits import REFUSALS_OF_ONE
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import CellState
from bt_orchestrator.script.users.keys import FRESH_S, LARGEST_NUMBER, Sealed, opened


@pytest.fixture
def bench(tmp_path: Path) -> SignedBench:
    return SignedBench(tmp_path)


def test_7_12_1_key_determines_name_and_role(bench: SignedBench) -> None:
    ann = bench.made('ann', Role.OPERATE)
    by = bench.send(ann, By('Bob', 'the terminal', 'why', Role.ENGINEER, Known.PAGE_LOGIN))
    assert (by.who, by.origin, by.reason) == ('ann', 'the terminal', 'why')
    assert (by.role, by.known, by.claims) == (Role.OPERATE, Known.SIGNED, '')
    assert by.known.proves_name
    assert by.signed is not None
    assert (by.signed.key, by.signed.public) == ('ann', ann.public)


@pytest.mark.parametrize('field', [field.name for field in fields(Sealed)])
def test_7_12_2_every_field_is_signed(bench: SignedBench, field: str) -> None:
    ann = bench.made('ann')
    text, public, signature = signed(ann, bench.request(ann))
    plain = json.loads(text)
    plain[field] = plain[field] + (1 if isinstance(plain[field], (int, float)) else 'x')
    with pytest.raises(CommandRefused, match='changed on the way'):
        bench.bring(json.dumps(plain), public, signature)
    assert bench.bring(text, public, signature).who == 'ann'


def test_7_12_2_neither_another_key_nor_another_signature_fits(bench: SignedBench) -> None:
    ann, bob = bench.made('ann'), bench.made('bob', Role.VIEW)
    text, _, signature = signed(bob, bench.request(bob))
    with pytest.raises(CommandRefused, match='changed on the way'):
        bench.bring(text, ann.public, signature)
    for wrong in (b'', bytes(64), signature[:-1], signature + b'x'):
        with pytest.raises(CommandRefused, match='changed on the way'):
            bench.bring(text, bob.public, wrong)


def test_7_12_2_signature_for_other_purpose_is_refused(
    bench: SignedBench,
) -> None:
    ann = bench.made('ann')
    text = bench.request(ann).text
    with pytest.raises(CommandRefused, match='changed on the way'):
        bench.bring(text, ann.public, ann._key.sign(text.encode()))


def test_7_12_3_unknown_key_is_refused(bench: SignedBench) -> None:
    ann = bench.made('ann')
    del bench.keys['ann']
    with pytest.raises(CommandRefused, match='user key NAME --role ROLE --public KEY'):
        bench.send(ann)


@pytest.mark.parametrize(
    ('other', 'why'),
    [
        ({'node': '/line_2'}, "another node, '/line_2'; this is '/bt_orchestrator'"),
        ({'history': 'h0'}, "another journal, 'h0'; this is 'h1'"),
        ({'boot': 'b0'}, "another start of the node's computer"),
        ({'uptime': 1000.0 + 3.0}, '3.0 s ahead of the uptime'),
        ({'uptime': float('nan')}, 'signed nan s ago'),
        ({'uptime': float('inf')}, 'inf s ahead'),
        ({'number': 0}, 'has used 0 already'),
        ({'number': -5}, 'has used 0 already'),
        ({'number': LARGEST_NUMBER + 1}, 'a copy'),
    ],
)
def test_7_12_4_request_fits_only_this_node_and_moment(
    bench: SignedBench, other: dict[str, Any], why: str
) -> None:
    ann = bench.made('ann')
    with pytest.raises(CommandRefused) as refused:
        bench.send(ann, **other)
    assert why in str(refused.value)
    assert bench.send(ann).who == 'ann'


def test_7_12_4_what_is_late_is_refused(bench: SignedBench) -> None:
    ann = bench.made('ann')
    in_time, late = signed(ann, bench.request(ann)), signed(ann, bench.request(ann))
    bench.later(FRESH_S)
    assert bench.bring(*in_time).who == 'ann'
    bench.later(0.1)
    with pytest.raises(CommandRefused, match=r'10\.1 s ago; expected at most 10 s'):
        bench.bring(*late)


def test_7_12_5_number_counts_once_and_in_order(bench: SignedBench) -> None:
    ann, bob = bench.made('ann'), bench.made('bob')
    first, second = (signed(ann, bench.request(ann)) for _ in range(2))
    assert bench.bring(*second).who == 'ann'
    for again in (second, first):
        with pytest.raises(CommandRefused, match='a copy, or a request that was overtaken'):
            bench.bring(*again)
    assert bench.send(bob).who == 'bob'


def test_7_12_5_untimely_request_uses_up_its_number(bench: SignedBench) -> None:
    """Whoever made a client sign for a later moment cannot bring it then."""
    ann = bench.made('ann')
    early = signed(ann, bench.request(ann, uptime=bench.here.up.seconds + 60.0))
    with pytest.raises(CommandRefused, match='ahead'):
        bench.bring(*early)
    bench.later(60.0)
    with pytest.raises(CommandRefused, match='a copy'):
        bench.bring(*early)


def test_7_12_5_numbers_go_on_where_the_record_ends(tmp_path: Path) -> None:
    recorded: dict[str, int] = {}
    bench = SignedBench(tmp_path, recorded)
    ann = bench.made('ann')
    old = signed(ann, bench.request(ann))
    recorded[ann.public] = opened(old[0]).number
    with pytest.raises(CommandRefused, match='a copy'):
        bench.bring(*old)
    assert bench.send(ann).who == 'ann'


def by_ann(number: int, reason: str = 'a test') -> By:
    signature = Signed('ann', 'AAAA', number)
    return By('ann', 'over there', reason, Role.ENGINEER, Known.SIGNED, '', signature)


def test_7_12_5_number_is_recorded_and_outlives_events() -> None:
    run = Line().run()
    run.ask(ask('cell.pause', by_ann(7)))
    run.ask(ask('cell.start', by_ann(9)))  # refused
    recorded = [row for row in run.records if row['event'] in ('request.signed', *_OPERATORS)]
    assert [row['event'] for row in recorded[-4:]] == [
        *('request.signed', 'operator.decided', 'request.signed', 'operator.refused'),
    ]
    signatures = [row for row in recorded if row['event'] == 'request.signed']
    assert [(row['key'], row['public'], row['number']) for row in signatures[-2:]] == [
        ('ann', 'AAAA', 7),
        ('ann', 'AAAA', 9),
    ]
    assert run.state.signatures == {'AAAA': 9}
    assert state_from_plain(run.state.cell, state_to_plain(run.state)).signatures == {'AAAA': 9}
    fresh = CellState(run.state.cell)
    for record in run.records:
        apply(fresh, from_record(record))
    assert fresh.signatures == {'AAAA': 9}


_OPERATORS = ('operator.decided', 'operator.refused')


def test_7_12_5_records_of_signatures_cannot_fill_the_disk() -> None:
    run = Line().run()
    before = len(run.records)
    for number in range(1, 400):
        run.ask(RefusedRequest('start', by_ann(number), 'no ' * 50))
    written = run.records[before:]
    assert sum(record['event'] == 'request.signed' for record in written) == sum(
        record['event'] == 'operator.refused' for record in written
    )
    assert sum(len(json.dumps(record)) for record in written) < REFUSALS_OF_ONE.at_once + 1000


@pytest.mark.parametrize(
    ('allowed', 'asserted', 'role', 'claims'),
    [
        (Role.ENGINEER, Role.ENGINEER, Role.ENGINEER, ''),
        (Role.ENGINEER, Role.MES, Role.MES, ''),
        (Role.OPERATE, Role.OPERATE, Role.OPERATE, ''),
        (Role.OPERATE, Role.ENGINEER, Role.OPERATE, 'engineer (page login)'),
        (Role.OPERATE, Role.MES, Role.VIEW, 'mes (page login)'),
        (Role.VIEW, Role.OPERATE, Role.VIEW, 'operate (page login)'),
    ],
)
def test_7_12_6_door_asserts_roles_up_to_its_own(
    bench: SignedBench, allowed: Role, asserted: Role, role: Role, claims: str
) -> None:
    page = bench.made('page_1', allowed, 'page')
    by = bench.send(page, user_of_door(asserted))
    assert (by.who, by.role, by.known, by.claims) == ('Ann', role, Known.PAGE_LOGIN, claims)
    assert by.signed is not None
    assert by.signed.key == 'page_1'


def test_7_12_6_door_asserts_no_foreign_users_or_itself(
    bench: SignedBench,
) -> None:
    page = bench.made('page_1', Role.ENGINEER, 'page')
    opcua = bench.made('mes', Role.ENGINEER, 'opcua')
    assert bench.send(page, user_of_door(Role.OPERATE, Known.PAGE_PANEL)).known.is_panel
    assert bench.send(opcua, user_of_door(Role.OPERATE, Known.OPC_UA_PANEL)).known.is_panel
    for key, known in ((page, Known.OPC_UA_USER), (opcua, Known.PAGE_PANEL), (page, Known.ROS)):
        with pytest.raises(CommandRefused, match='asks for its users alone'):
            bench.send(key, user_of_door(Role.OPERATE, known))
    with pytest.raises(CommandRefused, match='asks for its users alone'):
        bench.send(page, user_of_door(Role.VIEW), known='local user')


def test_7_12_7_ros_panel_key_is_named_by_file(bench: SignedBench) -> None:
    bench.panels = ('panel_3', 'page_1')
    panel, ann = bench.made('panel_3', Role.OPERATE), bench.made('ann')
    page = bench.made('page_1', Role.OPERATE, 'page')
    by = bench.send(panel)
    assert (by.known, by.known.is_panel, by.known.proves_name) == (Known.SIGNED_PANEL, True, True)
    assert not bench.send(ann, By('panel_3', '', 'why', Role.VIEW)).known.is_panel
    assert not bench.send(page, user_of_door(Role.OPERATE)).known.is_panel


@pytest.mark.parametrize(
    'text',
    [
        *('', 'null', '[]', '{}', 'x' * 10, '{"name": "cell.start"}', '[' * 100_000),
        json.dumps({field.name: 1 for field in fields(Sealed)}),
        json.dumps({field.name: 'x' for field in fields(Sealed)}),
    ],
)
def test_7_12_malformed_request_is_refused_in_words(text: str) -> None:
    with pytest.raises(CommandRefused, match='a signed request is JSON with name, arguments'):
        opened(text)


def test_7_12_half_a_character_and_a_flood_are_refused(bench: SignedBench) -> None:
    request = bench.request(bench.made('ann'))
    with pytest.raises(CommandRefused, match='is JSON with'):
        opened(request.text.replace('Eve', '\\ud800'))
    with pytest.raises(CommandRefused, match='too long'):
        opened(replace(request, arguments='x' * 4_000_000).text)


def test_7_12_a_true_is_no_number(bench: SignedBench) -> None:
    text = replace(bench.request(bench.made('ann')), number=True).text
    with pytest.raises(CommandRefused):
        opened(text)
