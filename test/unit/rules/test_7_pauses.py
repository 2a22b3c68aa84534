"""Semantics 7.3: pauses have owners, stack, and are released one by one."""

from __future__ import annotations

from fakes.line import THREE, Line
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.cell_commands import Pause, Resume


def paused(*who: str) -> VirtualRun:
    run = Line().begin(quantity=2).go(until=3.5)
    for name in who:
        assert run.command(Pause, who=name).accepted
    return run.go()


def test_7_3_two_pauses_need_two_resumes() -> None:
    run = paused('Ann', 'Bob')
    answer = run.command(Resume, who='Ann')
    assert answer.accepted
    assert answer.message == 'still paused: hold 2 (paused, Bob: it is so)'
    run.go()
    assert run.state.mode.value == 'Held'
    assert run.command(Resume, who='Bob').message == 'the cell goes on'
    run.go()
    assert run.ended


def test_7_3_nobody_resumes_for_others_by_mistake() -> None:
    run = paused('Ann')
    answer = run.command(Resume, who='Bob')
    assert not answer.accepted
    assert answer.message == (
        'no pause is yours; hold 1 (paused, Ann: it is so); whoever paused resumes, or name the '
        'hold to release it for them'
    )
    assert list(run.state.holds) == ['1']


def test_7_3_a_pause_can_be_named() -> None:
    run = paused('Ann', 'Bob')
    assert not run.command(Resume, who='Cat', hold='7').accepted
    assert run.command(Resume, who='Cat', hold='2').accepted
    assert list(run.state.holds) == ['1']


def test_7_3_all_pauses_can_be_released_at_once() -> None:
    run = paused('Ann', 'Bob', 'Ann')
    assert run.command(Resume, who='Cat', everyones=True).accepted
    run.go()
    assert run.ended


def test_7_3_all_pauses_of_one_owner_are_released_together() -> None:
    run = paused('Ann', 'Ann')
    assert run.command(Resume, who='Ann').accepted
    assert not run.state.holds


def test_7_3_a_pause_before_an_order_keeps_the_cell_from_working() -> None:
    line = Line()
    run = VirtualRun(line.cell, line.types)
    run.command(Pause)
    run.submit('J', line.script(THREE))
    run.go()
    assert run.state.mode.value == 'Held'
    assert run.all('task.started') == []
    run.command(Resume)
    run.go()
    assert run.ended


def test_7_3_a_pause_releases_nothing_that_is_held() -> None:
    run = Line(faults={'a2': '#1=abort'}).run()
    run.command(Pause)
    assert run.command(Resume).message == 'no longer paused; it waits for answers to hold 1'
