"""Contests: other clients or servers of a component, as events (semantics 2.5, 9.2)."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timezone

from bt_orchestrator.engine.runtime.cell_commands import RESUME
from bt_orchestrator.model import events as e
from bt_orchestrator.model.goal import Contest, SeenContest
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import UNKNOWN_GOAL
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
