"""News from around the line: other clients and servers of components, and the safety input.

Holds that need a look at the line are made here (semantics 2.5, 7.3, 9.2). The safety input is no
safety function: one loss has one consequence, however often the input flaps (7.9).
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timezone

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.cell_commands import RESUME, events_of_abort
from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.goal import NOT_HEARD, Contest, SafetyReading, SeenContest
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import SAFETY, UNKNOWN_GOAL
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import Servers


def seen(state: CellState, news: SeenContest) -> Iterator[e.Event]:
    """Record what was seen, if it is another contest than before.

    The goal of a task that is in flight or in doubt is our own. A goal that the state does not
    know and that ran before this orchestrator started shows that the journal is incomplete.
    """
    known = {task.goal for task in state.tasks.values()}
    before = state.contests.get(news.component, Contest())
    goals = tuple(goal for goal in news.contest.goals if goal not in known)
    contest = Contest(news.contest.servers, goals)
    if contest == before:
        return
    yield e.ComponentContested(
        component=news.component, servers=contest.servers, goals=contest.goals
    )
    for goal in goals:
        if goal in news.before and goal not in before.goals and not _is_asked(state, goal):
            yield to_be_named(state, UNKNOWN_GOAL, _message(state, news, goal))


def restarted(state: CellState, servers: Servers) -> list[e.Event]:
    """Return what is lost where a controller is another process than the one that was set up."""
    return [
        e.ComponentSetupLost(component=name)
        for name, setups in state.setups.items()
        for present in (servers.server(name),)
        if present is not None
        and any(setup.server not in (None, present) for setup in setups.values())
    ]


def _is_asked(state: CellState, goal: str) -> bool:
    """Tell whether a hold concerns a goal, perhaps from an earlier start."""
    holds = (hold for hold in state.holds.values() if hold.reason == UNKNOWN_GOAL)
    return any(goal in hold.message for hold in holds)


def _message(state: CellState, news: SeenContest, goal: str) -> str:
    action = state.cell.components[news.component].action
    server = f'{action} at {news.node}' if news.node else action
    return sentence('unknown_goal', server=server, goal=goal, time=in_utc(news.before[goal]))


# Holds that ask an operator to check the line (semantics 7.3).


def to_be_named(state: CellState, reason: str, message: str) -> e.HoldRaised:
    """Return a hold of the whole cell that is released only by its name.

    :param reason: one of `model.stop_reason.NAMED`
    :param message: what the operator has to check
    """
    return e.HoldRaised(hold=state.next_hold, reason=reason, message=message, answers=(RESUME,))


def in_utc(seconds: float) -> str:
    """Write a time of the wall clock."""
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return f'{moment:%Y-%m-%d %H:%M:%S} UTC'


# --- the safety input (semantics 7.9) ------------------------------------------------------------

_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)


class SafetyGuard:
    """Tells a loss from a further cause of the same loss."""

    def __init__(self) -> None:
        self._was_told = False
        """Before that, an input that is not ready is a loss as well: that of a take-over."""

    def seen(self, state: CellState, reading: SafetyReading) -> Iterator[e.Event]:
        """Yield what follows from the present state of the input."""
        is_ready = not reading.unsafe
        is_loss = not is_ready and not (state.unsafe and self._was_told)
        self._was_told = True
        if is_loss or is_ready is bool(state.unsafe):
            yield e.SafetyChanged(ready=is_ready, reason=reading.unsafe)
        if is_loss:
            yield from _lost(state, sentence('unsafe', words=reading.unsafe))


def _lost(state: CellState, words: str) -> Iterator[e.Event]:
    """Cancel every goal, or hold the line where no goal is in flight."""
    if state.packml in _ABORTED:
        return
    if state.running:
        yield from events_of_abort(state, words)
    elif not any(hold.reason == SAFETY for hold in state.holds.values()):
        yield to_be_named(state, SAFETY, words)


def taken_over(state: CellState) -> Iterator[e.Event]:
    """Begin without news of the input, or without an input."""
    if state.cell.safety is not None:
        yield e.SafetyChanged(ready=False, reason=NOT_HEARD)
    elif state.unsafe:
        yield e.SafetyChanged(ready=True)


def refuse_unsafe(state: CellState, command: Command) -> None:
    """Refuse a request that lets something start while the input is not ready.

    :raises CommandRefused: says why it is not ready
    """
    request = getattr(command, 'request', None)
    if state.unsafe and request is not None and request.needs_safety:
        why = sentence('unsafe', words=state.unsafe)
        raise CommandRefused(sentence('refused_because', request=request.name, words=why))
