"""Runs whose clock somebody sets: what happened stays the same, the times on record do not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from hypothesis import strategies as st

from bt_orchestrator.model import events as e
from bt_orchestrator.view.report.account.total import Times

Steps = Sequence[tuple[int, float]]
"""Shares of the events, in hundredths, after which the clock is set, and by how many seconds."""

SHARES = st.integers(0, 99)
ANY = st.floats(1.0, 5000.0).map(lambda seconds: round(seconds, 3))


def drawn_steps(seconds: st.SearchStrategy[float] = ANY) -> st.SearchStrategy[Steps]:
    """Draw steps, forward and back."""
    signed = st.tuples(seconds, st.sampled_from([-1, -1, 1])).map(lambda pair: pair[0] * pair[1])
    return st.lists(st.tuples(SHARES, signed), min_size=1, max_size=4)


def nameless(times: Times) -> Times:
    """Return an account without the names of its stops: a step of the clock is an event more."""
    stops = (stop._replace(span=replace(stop.span, seq=0)) for stop in times.line_stops)
    return replace(times, line_stops=tuple(stops))


def stepped(events: Iterable[e.Event], steps: Steps) -> list[e.Event]:
    """Return events as a node records them whose clock is set; each step is an event more."""
    events = list(events)
    due = sorted((max(1, share * len(events) // 100), seconds) for share, seconds in steps)
    result: list[e.Event] = []
    ahead_s = 0.0
    for number, event in enumerate(events):
        while due and due[0][0] <= number:
            _, seconds = due.pop(0)
            ahead_s += seconds
            step = e.ClockStepped(seconds=seconds)
            result.append(step.stamped(len(result) + 1, event.time + ahead_s))
        result.append(_by_the_clock(event, ahead_s).stamped(len(result) + 1, event.time + ahead_s))
    return result


def _by_the_clock(event: e.Event, ahead_s: float) -> e.Event:
    if isinstance(event, e.TaskRetrying):
        return replace(event, not_before=event.not_before + ahead_s)
    return event
