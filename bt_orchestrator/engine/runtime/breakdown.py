"""The work that goes on when the journal cannot be written: cancelling goals, off the record."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Answer, Command, cancels_all
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ports import ActionGateway, Goal

log = logging.getLogger(__name__)


class Breakdown:
    """The engine's remaining functions without a journal (semantics 9.1).

    It sends and records nothing. `abort` and the end of the node cancel every goal whose end is
    not known; every other command is refused.
    """

    def __init__(
        self, failure: str, goals: Mapping[str, tuple[e.TaskKey, Goal]], gateway: ActionGateway
    ) -> None:
        """Take over the goals of an engine.

        :param failure: why the journal cannot be written
        :param goals: by their UUID
        """
        self._failure = failure
        self._goals = dict(goals)
        self._gateway = gateway
        self._asked: set[str] = set()
        self.look()

    @property
    def message(self) -> str:
        """The error, what happens to the goals, and what to do."""
        return (
            f'{self._failure}; nothing is sent any more, {self._of_goals()}. Make room or mend '
            'the file, and start the orchestrator again: it takes over from the journal'
        )

    @property
    def in_flight(self) -> list[str]:
        """The goals that have not ended, in words."""
        return [f'{key} (goal {uuid})' for uuid, (key, _) in self._open().items()]

    def answer(self, command: Command) -> Answer:
        """Cancel every goal, or refuse."""
        if not cancels_all(command):
            return Answer(accepted=False, message=self.message)
        done = self._cancel_all()
        what = f'Abort by {command.by}' if isinstance(command, Asked) else 'Shutdown'
        log.error('%s, off the record: %s', what, done)
        return Answer(
            accepted=True,
            message=f'{done}; this is not on record: {self._failure}. Make room or mend the file, '
            'start the orchestrator again and say abort once more: it does not know of this one',
        )

    def look(self) -> None:
        """Note which goals have ended; nothing else drains the gateway any more."""
        self._gateway.drain()
        self._goals = self._open()

    def _cancel_all(self) -> str:
        found = self._open()
        for _, goal in found.values():
            goal.cancel()
        self._asked.update(found)
        number = len(found)
        return f'{number} goal{"s are" if number != 1 else " is"} being cancelled'

    def _open(self) -> dict[str, tuple[e.TaskKey, Goal]]:
        return {uuid: flight for uuid, flight in self._goals.items() if flight[1].end is None}

    def _of_goals(self) -> str:
        if not self._asked:
            return 'what runs goes on to its end unless abort cancels it'
        left = len(self._asked & self._open().keys())
        return f'{len(self._asked)} asked to cancel without a record, {left} of them not ended'
