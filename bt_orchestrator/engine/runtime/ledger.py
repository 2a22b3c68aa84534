"""The ledger stamps, applies and keeps events until they are durable; delays between attempts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.model.events import ClockStepped, Event, TaskKey
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.script import index_task
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.model.uptime import seconds_between, step_between
from bt_orchestrator.ports import Clock, Servers, Timer


class _Delay(NamedTuple):
    not_before: float
    """As recorded, on the wall clock."""
    until: float
    """On the steady clock."""


class Delays:
    """The end of each retry's delay, on the steady clock.

    The remaining time is computed once, at the first request, from the machine's uptime. After a
    boot, or on another machine, the delay begins anew. If no uptime was recorded, the wall clock
    is used, for no more than the task's delay.
    """

    def __init__(self, state: CellState, clock: Clock) -> None:
        self._state = state
        self._clock = clock
        self._found: dict[TaskKey, _Delay] = {}

    def left(self, key: TaskKey) -> float | None:
        """Return until when a task waits, on the steady clock; None: its delay is over."""
        not_before = self._state.tasks[key].not_before
        delay = self._found.get(key)
        if delay is None or delay.not_before != not_before:
            delay = self._found[key] = _Delay(not_before, self._until(key, not_before))
            self._forget()
        return None if has_come(delay.until, self._clock.steady()) else delay.until

    def _until(self, key: TaskKey, not_before: float) -> float:
        decided = self._state.tasks[key]
        ago_s = seconds_between(decided.delayed_up, self._clock.uptime())
        if ago_s is not None:
            return self._clock.steady() + decided.delay_s - ago_s
        if decided.delayed_up is not None:
            return self._clock.steady() + decided.delay_s
        task = self._state.task(key) or index_task(self._state.cell)
        left_s = min(max(not_before - self._clock.now(), 0.0), task.retry_delay_s)
        return self._clock.steady() + left_s

    def _forget(self) -> None:
        tasks = self._state.tasks
        over = [k for k in self._found if k not in tasks or tasks[k].phase is not Phase.RETRYING]
        for key in over:
            del self._found[key]


# The wait for a state topic that does not tell a setup as a task asks for it.

TOLD_WITHIN_S = 5.0
"""Seconds within which a state topic tells what a component is set up for (semantics 5.3)."""


class Tellings:
    """The end of each wait for a state topic, from when the attempt could have started.

    A new orchestrator lets each begin anew.
    """

    def __init__(self, state: CellState, clock: Clock) -> None:
        self._state = state
        self._clock = clock
        self._asked: dict[TaskKey, tuple[tuple[int, int], float]] = {}
        """The attempt and its round, and the end of the wait on the steady clock."""

    def until(self, key: TaskKey) -> float | None:
        """Return until when a task waits, on the steady clock; None: its wait is over."""
        before = self._state.tasks.get(key)
        attempt = (before.attempt if before is not None else 0, self._state.round(key))
        asked = self._asked.get(key)
        if asked is None or asked[0] != attempt:
            asked = self._asked[key] = attempt, self._clock.steady() + TOLD_WITHIN_S
            over = [task for task in self._asked if task.job not in self._state.jobs]
            for task in over:
                del self._asked[task]
        return None if has_come(asked[1], self._clock.steady()) else asked[1]


Notice = Callable[[Any], None]


class _Noticing(dict[type[Event], tuple[Notice, ...]]):
    """The functions that are called with the events of each class, made at the first of them."""

    def __init__(self, notices: Callable[[type[Event]], Iterable[Notice]]) -> None:
        super().__init__()
        self._notices = notices

    def __missing__(self, kind: type[Event]) -> tuple[Notice, ...]:
        notices = self[kind] = tuple(self._notices(kind))
        return notices


class Ledger:
    """The state and its pending events. Implements `tree.subject.Recorder`.

    An event applies at once and is committed at the end of the settle
    (architecture, "One settle").
    """

    def __init__(
        self,
        state: CellState,
        clock: Clock,
        notices: Callable[[type[Event]], Iterable[Notice]],
        new_goal_id: Callable[[], str],
        servers: Servers,
        on_time: Callable[[], None],
    ) -> None:
        """Open a ledger.

        :param notices: returns what is called with each event of a class once it is applied
        :param on_time: called at a time requested by `wake_at`
        """
        self.state = state
        self._clock = clock
        self._noticing = _Noticing(notices)
        self._new_goal_id = new_goal_id
        self._servers = servers
        self._on_time = on_time
        self._pending: list[Event] = []
        self._delays = Delays(state, clock)
        self._tellings = Tellings(state, clock)
        self._wall = WallClock(clock)
        self._armed: dict[float, Timer] = {}

    @property
    def now(self) -> float:
        """Seconds of the wall clock, for records."""
        return self._clock.now()

    @property
    def steady(self) -> float:
        """Seconds of the steady clock, which is never set."""
        return self._clock.steady()

    @property
    def uptime(self) -> float | None:
        """How long the machine had been up at the time that stamps events; None: not known."""
        up = self._clock.uptime()
        if up is None:
            return None
        return round(up.seconds - (self._clock.steady() - self._wall.steady), 6)

    def record(self, events: Iterable[Event]) -> None:
        """Stamp and apply new events, in order, each before the next one is taken."""
        state, now = self.state, self._wall.now
        for event in events:
            event.stamp(state.seq + 1, now)
            apply(state, event)
            self._pending.append(event)
            for notice in self._noticing[type(event)]:
                notice(event)

    def look_at_clock(self) -> None:
        """Read the time that stamps events from now on; record it if the wall clock was set.

        Called at the beginning of each settle and of each command.
        """
        step_s = self._wall.step_s()
        if step_s:
            self.record([ClockStepped(seconds=step_s, uptime=self.uptime)])

    def look_back(self) -> None:
        """Record that the wall clock was set since the last event, if the uptime proves that.

        Called at the start. Nobody knows when the step came while no node ran: it counts as if it
        had come right after the last event, so the time after it is time without a node.
        """
        state, wall = self.state, self._wall
        before = state.clock
        step_s = step_between(before, self._clock.now(), self._clock.uptime())
        if before is None or abs(step_s) < CLOCK_STEP_S:
            return
        step_s = min(step_s, wall.now - state.time)  # uptimes are rounded
        up_s = before.up.seconds + state.time - before.wall
        now, wall.now = wall.now, state.time + step_s
        self.record([ClockStepped(seconds=step_s, uptime=round(up_s, 3))])
        wall.now = now

    @property
    def has_pending(self) -> bool:
        """Tell whether anything was recorded since `take_pending`."""
        return bool(self._pending)

    def pending_after(self, seq: int) -> list[Event]:
        """Return the events recorded after a number, and not taken yet."""
        return [event for event in self._pending if event.seq > seq]

    def take_pending(self) -> list[Event]:
        """Return the events recorded since the last call."""
        pending, self._pending = self._pending, []
        return pending

    def new_goal_id(self) -> str:
        """Return a goal UUID that was never used."""
        return self._new_goal_id()

    def server(self, component: str) -> str | None:
        """Return the instance of a component's server that was seen last; None: not known."""
        return self._servers.server(component)

    def rivals(self, component: str) -> Sequence[str]:
        """Return the servers of a component's action at this moment, if there are several."""
        return self._servers.rivals(component)

    def is_delayed(self, key: TaskKey) -> bool:
        """Tell whether the next attempt of a task waits for its time; a settle follows then."""
        until = self._delays.left(key)
        if until is not None:
            self.wake_at(until)
        return until is not None

    def awaits_setup(self, key: TaskKey) -> bool:
        """Tell whether a task waits for a topic to tell its setup; a settle ends the wait."""
        until = self._tellings.until(key)
        if until is not None:
            self.wake_at(until)
        return until is not None

    def wake_at(self, time: float) -> None:
        """Request a settle at a steady time; a repeated request changes nothing."""
        if time not in self._armed:
            self._armed[time] = self._clock.call_at(time, lambda: self._expire(time))

    def close(self) -> None:
        """Forget every deadline."""
        for timer in self._armed.values():
            timer.cancel()
        self._armed.clear()

    def _expire(self, time: float) -> None:
        del self._armed[time]
        self._on_time()


# Detecting that the wall clock was set (semantics 2.4).

CLOCK_STEP_S = 1.0
"""A smaller step counts as slewing; NTP corrections of a slow or fast clock are far smaller."""


class WallClock:
    """Compares how far the wall clock and the steady clock have moved since the last look.

    So a slewed clock is followed. A step of less than CLOCK_STEP_S counts as slewing.
    """

    def __init__(self, clock: Clock) -> None:
        self._now, self._steady = clock.now, clock.steady
        self.now = 0.0
        """As it was at the last look."""
        self.steady = 0.0
        """The steady clock at the last look."""
        self._ahead_s = self._look()

    def step_s(self) -> float:
        """Return by how many seconds it was set since the last look; 0.0: it was not set."""
        ahead_s = self._look()
        if -CLOCK_STEP_S < ahead_s - self._ahead_s < CLOCK_STEP_S:
            self._ahead_s = ahead_s
            return 0.0
        # Read again: the process may have been suspended between the two readings.
        ahead_s = self._look()
        step_s, self._ahead_s = ahead_s - self._ahead_s, ahead_s
        return step_s if abs(step_s) >= CLOCK_STEP_S else 0.0

    def _look(self) -> float:
        self.now, self.steady = self._now(), self._steady()
        return self.now - self.steady
