"""Semantics 7.8: in local only the panels move the line, and switching stops nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from fakes.line import THREE, Line
from fakes.request_bench import RequestBench
from fakes.virtual_run import VirtualRun
from fakes.who_may import differences, rows

from bt_orchestrator.base.replies import begin
from bt_orchestrator.model.by import By, Control, Known, Role
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import REQUESTS, About, Request, ask

LINE = Line()
SCRIPT = LINE.script(THREE)


def at(known: Known, role: Role = Role.ENGINEER) -> By:
    return By('Eve', 'over there', 'a test', role, known)


PANEL, PAGE, ROS = at(Known.PAGE_PANEL), at(Known.PAGE_LOGIN), at(Known.ROS)


def in_local(run: VirtualRun) -> VirtualRun:
    assert run.ask(ask('cell.local', PANEL)).accepted
    assert run.state.control is Control.LOCAL
    return run


def test_7_8_1_request_must_declare_whether_it_moves() -> None:
    with pytest.raises(TypeError, match='moves'):
        Request('oil', About.CELL, 'oils it', frozenset({Role.OPERATE}))  # type: ignore[call-arg]


def test_7_8_1_request_table_agrees_with_page() -> None:
    moving = {row.request for row in rows() if row.cells['elsewhere in local'] == 'local'}
    assert {name for name, request in REQUESTS.items() if request.moves} == moving


@pytest.mark.parametrize('known', Known, ids=lambda entry: str(entry.value))
def test_7_8_1_requests_by_role_match_handwritten_table(known: Known, tmp_path: Any) -> None:
    bench = RequestBench(tmp_path)

    def asked(name: str, given: Mapping[str, Any], role: Role, is_panel: bool) -> str:
        sender = at(known.at_panel() if is_panel else known, role)
        if is_panel and not sender.known.is_panel:
            sender = at(Known.PAGE_PANEL, role)
        return begin(bench.handler.carry_out(ask(name, sender, **given))).value.message

    def hand_over(control: str) -> None:
        if bench.sim.state.control.value != control:
            answer = begin(bench.handler.carry_out(ask(f'cell.{control}', PANEL))).value
            assert answer.accepted, answer

    def lose() -> None:
        bench.sim.gateway.say_of_safety('its value is False')
        bench.sim.orchestrator.settle()

    diffs = list(differences(asked, hand_over, lose))
    if known.is_panel:  # it is never elsewhere
        assert all('elsewhere in local: local' in entry for entry in diffs)
        assert len(diffs) == sum(entry.moves for entry in REQUESTS.values() for _ in entry.roles)
    else:
        assert diffs == []


def test_7_8_1_refusal_names_allowed_origin_and_is_recorded() -> None:
    run = in_local(Line().run())
    before = len(run.records)
    answer = run.ask(ask('cell.reset', ROS))
    assert answer.message == (
        'cell.reset moves the line, which is in local: only its panels may do that, and somebody '
        'who claims to be Eve (ros unauthenticated) is at none; nothing was done; give control '
        'back at a panel with remote; without one, start the node anew with --control remote'
    )
    (refused,) = run.records[before:]
    assert (refused['event'], refused['command']) == ('operator.refused', 'reset')


def test_7_8_2_remote_orders_wait_for_release_at_panel() -> None:
    run = in_local(VirtualRun(LINE.cell, LINE.types))
    answer = run.ask(AddJobs((Job('J', SCRIPT, 1, {}),), PAGE))
    assert answer.message == (
        'J is queued and held\nthe line is in local: a panel has to release what was queued'
    )
    run.go()
    assert run.state.packml.value == 'Stopped'
    assert 'local' in run.ask(ask('job.release', PAGE, job='J')).message
    assert run.ask(ask('job.release', PANEL, job='J')).accepted
    run.go()
    assert run.state.packml.value == 'Complete'


def test_7_8_2_an_order_of_a_panel_starts_by_itself() -> None:
    run = in_local(VirtualRun(LINE.cell, LINE.types))
    assert run.ask(AddJobs((Job('J', SCRIPT, 1, {}),), PANEL)).message == 'J is queued'
    run.go()
    assert run.state.packml.value == 'Complete'


def test_7_8_4_without_a_panel_local_is_refused(tmp_path: Any) -> None:
    bench = RequestBench(tmp_path)
    answer = begin(bench.handler.carry_out(ask('cell.local', PAGE))).value
    assert not answer.accepted
    assert answer.message == (
        'a line in local needs a panel that can move it: a virtual line has no panels'
    )
    assert bench.sim.state.control is Control.REMOTE
    assert begin(bench.handler.carry_out(ask('cell.local', PANEL))).value.accepted


def test_7_8_5_control_switch_starts_and_stops_nothing() -> None:
    run = VirtualRun(LINE.cell, LINE.types)
    run.submit('J', SCRIPT, 2)
    run.go(5.0)
    running = dict(run.state.running)
    assert running
    in_local(run)
    assert dict(run.state.running) == running
    (changed,) = run.all('cell.control_changed')
    assert (changed['control'], changed['reason']) == ('local', 'Eve: a test')
    run.go()
    assert run.state.packml.value == 'Complete'
    assert 'already' in run.ask(ask('cell.local', PANEL)).message
    assert run.ask(ask('cell.remote', PANEL)).accepted
    assert run.state.control is Control.REMOTE
