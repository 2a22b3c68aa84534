"""Holds of a virtual run, with predefined answers (semantics 7.1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.failures import AGAIN, CHANGE, MARK_DONE, RETRY
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.requests import Asked, answering, possible_answers
from bt_orchestrator.model.state import Hold
from bt_orchestrator.sim.simulation import Simulation

POSSIBLE = (*possible_answers(), VERBS[Cause.UNHOLD])
"""The possible predefined answers; the last one is for too many rejects (semantics 7.7)."""

MOST_RETRIES = 10
"""Maximum retries of one task of one item; after that it would fail always."""


class StandingAnswers:
    """An operator who always gives the same answers, after the same time."""

    def __init__(
        self,
        simulation: Simulation,
        answers: Sequence[str],
        after_s: float,
        who: str,
        results: Mapping[str, Mapping[str, Any]] | None = None,
    ) -> None:
        """Stand by.

        :param answers: the first one that a hold offers is given
        :param results: by task, what `mark_done` gives
        """
        self._results = results or {}
        self._simulation = simulation
        self._answers = tuple(answers)
        self._after_s = after_s
        self._by = By(who, '', 'decided beforehand', Role.ENGINEER, Known.LOCAL_USER)
        self._seen: dict[str, str] = {}
        """The answer to each hold; empty where there was none to give."""
        self._retries: Counter[tuple[TaskKey | None, int]] = Counter()
        """By task, and by beat: the belt's own move is the same task in each."""
        self._complaints: list[str] = []

    def look(self) -> None:
        """Schedule answers to new holds."""
        state, clock = self._simulation.state, self._simulation.clock
        for hold in [hold for hold in state.holds.values() if hold.id not in self._seen]:
            answer = self._seen[hold.id] = self._answer_to(hold)
            if answer:
                when = clock.steady() + self._after_s
                clock.call_at(when, partial(self._give, hold, answer))

    def complaints(self) -> list[str]:
        """Say why holds are left."""
        left = self._simulation.state.holds
        stay = [
            f'hold {hold} stays after {answer}; another answer has to end it'
            for hold, answer in self._seen.items()
            if answer and hold in left
        ]
        return [*self._complaints, *stay]

    def _answer_to(self, hold: Hold) -> str:
        answer = next((answer for answer in self._answers if answer in hold.answers), '')
        if not answer:
            self._complaints.append(
                f'hold {hold.id} does not offer {" or ".join(self._answers)}, '
                f'but {", ".join(hold.answers)}'
            )
        elif answer in (RETRY, AGAIN, CHANGE) and self._is_in_vain(hold):
            self._complaints.append(
                f'{hold.key} was tried again {MOST_RETRIES} times and failed each time; '
                f'{hold_name(hold)} is left without an answer'
            )
            return ''
        return answer

    def _is_in_vain(self, hold: Hold) -> bool:
        tried = (hold.key, self._simulation.state.beat)
        self._retries[tried] += 1
        return self._retries[tried] > MOST_RETRIES

    def _give(self, hold: Hold, answer: str) -> None:
        now = self._simulation.state.holds.get(hold.id)
        if now is None:
            return  # another answer ended it, abort_job for example
        if answer not in now.answers:
            del self._seen[hold.id]  # since then its item was rejected, or its job aborted
            self.look()
            return
        request, about = answering(hold, answer)
        marked = answer == MARK_DONE and hold.item is not None
        results = {'results': self._results.get(hold.task or '', {})} if marked else {}
        asked = Asked(request, self._by, {**about, **results})
        given = self._simulation.orchestrator.ask(asked)
        if not given.accepted:
            self._complaints.append(given.message)
