"""The operator of the line that is shot at: gives orders and answers holds, whoever is dead."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from bt_orchestrator_interfaces.srv import AnswerHold, Command, SubmitOrder
from chaos.truth import Controllers, Place, attempts, journal
from node_watcher import NodeWatcher

from bt_orchestrator.engine.runtime.cell_commands import RESUME
from bt_orchestrator.model.goal import Reason

ANSWERED_S = 2.0
"""An operator who hears nothing for that long asks again."""

_MOST_UNHEARD = 5
"""An operator who was not heard so often opens another terminal."""

_QUIET_S = 15.0
"""So does one who hears no status for that long: there is one a second."""

ENDED = 'Ended'


class _Nothing:
    """What an operator waits for who has asked for nothing."""

    def done(self) -> bool:
        return True


class Operator:
    """Looks at the last status, and asks for one thing at a time.

    :ivar orders: how many orders were given; as soon as one has ended the next one is
    :ivar gives_more: whether there is to be a next one
    """

    def __init__(
        self,
        watch: NodeWatcher,
        script: str,
        items: int,
        journal: Place,
        log: Path,
        spared: str = '',
    ) -> None:
        """Prepare.

        :param spared: whose pauses are not released, if anybody's
        """
        self._watch = watch
        self._script = script
        self._items = items
        self._journal = journal
        self._log = log
        self._spared = spared
        self.orders = 1
        self.gives_more = True
        self._asked: Any = _Nothing()
        self._patient_until = 0.0
        self._looked_at = 0
        """Statuses that were there at the last request."""
        self._unheard = 0
        self._heard, self._heard_s = 0, time.monotonic()

    def look(self) -> None:
        """Do what there is to do."""
        answered = self._asked.done() and len(self._watch.statuses) > self._looked_at
        if not answered and time.monotonic() < self._patient_until:
            return
        request = next(self._due(), None)
        if request is None:
            return
        # Of a node that is no more, perhaps, or that had not discovered the operator yet.
        self._patient_until = time.monotonic() + ANSWERED_S
        self._unheard = 0 if self._asked.done() else self._unheard + 1
        kind, service, fields = request
        self._looked_at = len(self._watch.statuses)
        self._asked = self._watch.send(kind, service, **fields)

    def is_done(self) -> bool:
        """Tell whether there is no order any more that has not ended, nor to be given."""
        return not self.gives_more and self._state_of_order() == ENDED

    def forget(self) -> None:
        """Expect no answer any more: another node is there, or another terminal."""
        self._asked, self._unheard, self._patient_until = _Nothing(), 0, 0.0
        self._heard_s = time.monotonic()  # a terminal has to be given time to hear something

    def is_cut_off(self, *, node_lives: bool) -> bool:
        """Tell whether nothing is heard of a node that lives."""
        if len(self._watch.statuses) != self._heard or not node_lives:
            self._heard, self._heard_s = len(self._watch.statuses), time.monotonic()
        return self._unheard > _MOST_UNHEARD or time.monotonic() - self._heard_s > _QUIET_S

    def _due(self) -> Iterator[tuple[Any, str, dict[str, Any]]]:
        """Yield what could be asked for: services, and what they are told."""
        for hold in self._watch.status.holds:
            if self._spared and hold.owner == self._spared:
                continue
            if RESUME in hold.answers:
                # By name, which says that the line was looked at (semantics 7.3).
                yield Command, 'command', {'command': RESUME, 'hold': hold.id}
            elif hold.answers:
                yield AnswerHold, 'answer_hold', {'hold': hold.id, 'answer': self._answer(hold)}
        state = self._state_of_order()
        if state == ENDED and self.gives_more:
            self.orders += 1
        if state in (ENDED, None) and not self.is_done():
            yield SubmitOrder, 'submit_order', self._order()

    def _order(self) -> dict[str, Any]:
        name = f'WO-{self.orders}'
        return {'order': name, 'script': self._script, 'quantity': self._items}

    def _state_of_order(self) -> str | None:
        name = f'WO-{self.orders}'
        state = next((job.state for job in self._watch.status.jobs if job.id == name), None)
        if state is None and self._watch.seen('job.completed', job=name):
            return ENDED  # so many have ended since that the status does not list it any more
        return state

    def _answer(self, hold: Any) -> str:
        """Decide as somebody does who has looked at the machine: its own log is the truth."""
        if hold.reason == Reason.MISSING_RESULT.value:
            return 'mark_done'  # by hand: what had the result was marked done, and has none
        done = any(Controllers(self._log).succeeded(goal) for goal in self._goals_of(hold))
        undone = 'retry' if 'retry' in hold.answers else 'skip'
        return 'mark_done' if done else undone

    def _goals_of(self, hold: Any) -> list[str]:
        """Return the goals that were to do what is held; of the belt: its last move."""
        goal_lists = [
            goals
            for work, goals in attempts(journal(self._journal)).items()
            if (work.key.item or '', work.key.task) == (hold.item, hold.task)
        ]
        return goal_lists[-1] if goal_lists else []
