"""A standby on another machine goes on: which goals it sends again (semantics 9.4)."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from fakes.clocks import SetClock
from fakes.commands import Abort
from fakes.line import Line, with_section
from fakes.operator import ann
from fakes.world import World, begun

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S
from bt_orchestrator.model.uptime import ClockReading, Uptime
from bt_orchestrator.store.memory import MemoryStore

WORK = with_section(2, '- {id: work, @a2.TASK_B}')


class LookedAt(MemoryStore):
    """A journal whose end another machine has looked at."""

    looks: tuple[tuple[int, ClockReading], ...] = ()

    def absent_at(self, seq: int) -> ClockReading | None:  # type: ignore[override]
        return next((at for seen, at in reversed(self.looks) if seen < seq), None)


def on_second_machine(clock: SetClock, wall_ahead_s: float = -9.0) -> None:
    clock.boot, clock.ahead_s = 'second machine', wall_ahead_s


def reading(clock: SetClock) -> ClockReading:
    up = clock.uptime()
    assert up is not None
    return ClockReading(clock.now(), up)


def killed_before_sending(
    looks: Callable[[int, ClockReading], tuple[tuple[int, ClockReading], ...]],
    wait_s: float = 0.0,
    first_does: Callable[[Orchestrator], object] = lambda _: None,
    then: Callable[[SetClock], None] = lambda _: None,
) -> tuple[World, Orchestrator]:
    """Kill a leader between commit and send; a standby that looked meanwhile goes on elsewhere.

    :param looks: returns what the standby has seen, of the last event before `work` was begun and
        the time on the second machine when it looked then
    """
    store = LookedAt()
    world = World(Line().cell, store)
    first = begun(world, Line().script(WORK), 1)
    world.gateway.unsent = 'TASK_B'
    world.go_until_starts(first, 'work')
    first_does(first)
    first.close()
    (started,) = (x for x in store.read() if isinstance(x, e.TaskStarted) and x.task == 'work')
    world.gateway.unsent = None
    on_second_machine(world.clock)
    store.looks = looks(started.seq, reading(world.clock))
    world.clock.sleep(wait_s)
    then(world.clock)
    second = world.orchestrator()
    world.go(second)
    return world, second


def before_the_start(seq: int, at: ClockReading) -> tuple[tuple[int, ClockReading], ...]:
    return ((seq - 1, at),)


def assert_asks_a_person(world: World, second: Orchestrator) -> None:
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']
    assert not world.events(e.TaskResent)


def test_9_4_goal_absent_from_recent_journal_is_resent() -> None:
    world, second = killed_before_sending(before_the_start)
    (resent,) = world.events(e.TaskResent)
    assert isinstance(resent, e.TaskResent)
    started = [x for x in world.events(e.TaskStarted) if isinstance(x, e.TaskStarted)]
    assert [x.goal for x in started if x.task == 'work'] == [resent.goal]
    assert second.state.ended['J'].progress.packed == 1


def test_9_4_without_a_look_a_person_is_asked() -> None:
    assert_asks_a_person(*killed_before_sending(lambda *_: ()))


def test_9_4_a_look_that_showed_the_goal_proves_nothing() -> None:
    assert_asks_a_person(*killed_before_sending(lambda seq, at: ((seq, at),)))


def test_9_4_a_server_may_have_forgotten_since_the_look() -> None:
    assert_asks_a_person(*killed_before_sending(before_the_start, wait_s=RESULT_TIMEOUT_S))


def test_9_4_a_look_of_an_earlier_boot_proves_nothing() -> None:
    def looks(seq: int, at: ClockReading) -> tuple[tuple[int, ClockReading], ...]:
        return ((seq - 1, at._replace(up=Uptime('before', at.up.seconds))),)

    assert_asks_a_person(*killed_before_sending(looks))


@pytest.mark.parametrize('ahead_s', [3600.0, -3600.0])
def test_9_4_stepped_wall_clock_proves_nothing(ahead_s: float) -> None:
    def set_clock(clock: SetClock) -> None:
        on_second_machine(clock, ahead_s)

    assert_asks_a_person(*killed_before_sending(before_the_start, then=set_clock))


def test_9_4_a_cancelled_goal_is_not_sent_again() -> None:
    def abort(first: Orchestrator) -> None:
        assert first.ask(Abort(ann('a hand in the cell'))).accepted

    world, second = killed_before_sending(before_the_start, first_does=abort)
    assert_asks_a_person(world, second)
    (hold,) = second.state.holds.values()
    assert 'the server does not know the goal' in hold.message, 'no proof that it never arrived'


def test_9_4_the_last_look_before_the_goal_counts() -> None:
    """An early look is too old, and a later one that shows the goal does not replace it."""

    def looks(seq: int, at: ClockReading) -> tuple[tuple[int, ClockReading], ...]:
        early = ClockReading(at.wall - 60.0, Uptime(at.up.boot, at.up.seconds - 60.0))
        return ((seq - 2, early), (seq - 1, at), (seq, at))

    world, _ = killed_before_sending(looks)
    assert len(world.events(e.TaskResent)) == 1
