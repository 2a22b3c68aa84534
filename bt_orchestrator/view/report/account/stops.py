"""Stops of the line, the holds that cause most of them, and failures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record, to_record
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.requests import is_remark
from bt_orchestrator.view.report.account.losses import WORDS, Loss, Part, Step
from bt_orchestrator.view.report.account.words import is_seen

MOST_HOLDS = 100
"""Holds that are listed one by one: those that cost most. Of all others number and time."""

"""Answers that change nothing."""


class Stop(NamedTuple):
    """All stops for one cause."""

    loss: Loss
    detail: str
    component: str
    times: int
    us: int
    part: Part = Part.WHOLE

    @property
    def about(self) -> str:
        """The exact cause, with its component."""
        if self.component in self.detail:
            return self.detail
        return f'{self.component}, {self.detail}'

    @property
    def is_shown(self) -> bool:
        """Tell whether it is a stop of the line that can be seen beside the others."""
        return WORDS[self.loss].step is Step.AVAILABILITY and is_seen(self.us)


@dataclass
class Held:
    """One hold that stood in planned time."""

    hold: str
    words: str
    raised_us: int
    released_us: int | None = None
    """None: it stands."""
    loss: Loss | None = None
    """The loss of its time; None: another hold was older all the time."""
    stood_us: int = 0
    """Planned time in which it stood."""
    lost_us: int = 0
    """The time that is booked to it."""
    who: str = ''
    answer: str = ''
    reason: str = ''
    """Why somebody answered so."""
    component: str = ''
    """The component that failed; empty: no failure."""
    fails: bool = False
    """The component failed in busy time."""
    down_us: int = 0
    """Busy time in which it stood, as a failure."""

    def told_as(self, newest: Held) -> None:
        """Take over what is known of it by now."""
        self.released_us = newest.released_us
        self.who, self.answer, self.reason = newest.who, newest.answer, newest.reason


class OpenHolds:
    """Takes in one event after another; knows the facts of the standing holds."""

    def __init__(self) -> None:
        self.open: dict[str, Held] = {}
        """In the order in which they were raised, without any time."""
        self._said: e.OperatorDecided | None = None

    def raised(self, event: e.HoldRaised, now: int, component: str) -> Held:
        """Take in a hold.

        :param component: the one that failed; empty: none did
        """
        held = Held(event.hold, hold_words(event), now, component=component)
        self.open[event.hold] = held
        return held

    def follow(self, event: e.Event, now: int) -> Held | None:
        """Take in any other event; returns the hold that is over with it."""
        if isinstance(event, e.OperatorDecided):
            self._decided(event)
        elif isinstance(event, e.HoldReleased):
            held = self.open.pop(event.hold, None)
            if held is not None:
                held.released_us = now
                if not held.answer and self._said is not None:
                    _answer(held, self._said)
            return held
        elif not isinstance(event, (e.HoldRaised, e.ItemRemoved, e.ClockStepped)):
            self._said = None
        return None

    def _decided(self, event: e.OperatorDecided) -> None:
        held = self.open.get(event.hold or '')
        if held is None:
            self._said = event  # `resume` and `remove-item` name no hold, and release it at once
        elif not is_remark(event.answer):
            _answer(held, event)

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        decision = None if self._said is None else to_record(self._said)
        return {'open': [asdict(hold) for hold in self.open.values()], 'said': decision}

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        self.open = {hold['hold']: Held(**hold) for hold in plain['open']}
        decision = plain['said']
        decided = None if decision is None else from_record(decision)
        self._said = decided if isinstance(decided, e.OperatorDecided) else None


def _answer(held: Held, event: e.OperatorDecided) -> None:
    held.who, held.answer, held.reason = event.who, event.answer, event.reason


def without_times(held: Held) -> Held:
    """Return a hold for the output, with new sums of its time."""
    return replace(held, loss=None, stood_us=0, lost_us=0, fails=False, down_us=0)


# Failures: of tasks by component, and of components with the time to their repair.

OF_COMPONENTS = (
    Reason.SERVER_UNAVAILABLE,
    Reason.GOAL_REJECTED,
    Reason.ABORTED,
    Reason.TIMEOUT,
    Reason.TASK_RESULT_FALSE,
    Reason.SERVER_LOST,
    Reason.IN_DOUBT,
)
"""Why a hold is a failure of its component; all else is about data, an item or a command."""

_REASONS = frozenset(reason.value for reason in OF_COMPONENTS)


def failing_component(hold: e.HoldRaised) -> str:
    """Return the component whose failure a hold is; empty: the hold is no failure."""
    return hold.component if hold.reason in _REASONS else ''


class FailingTask(NamedTuple):
    """All attempts of a task that failed for one reason."""

    component: str
    """Empty: nothing was sent."""
    task: str
    """Task constant; where nothing was sent the id of the task."""
    reason: str
    times: int
    us: int
    """How long these attempts took."""


@dataclass
class Repairs:
    """Failures of one component that needed a person."""

    component: str
    failures: int = 0
    down_us: int = 0
    """Planned busy time from its holds to their release."""
    repair_us: int = 0
    """The same, without the time that is booked to older holds, or to other losses."""
