"""A hold in words: all sentences about holds are made here, from data.

`hold_words` is the complete text, for status, views, logs and pictures. `hold_name` is used inside
other sentences: refusals, waits, the stop reason.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from bt_orchestrator.model.one_line import one_line


class HoldFacts(Protocol):
    """A hold as an event, in the state, or in a status message; empty or 0: not known, or none."""

    @property
    def section(self) -> int | None:
        """Section; none for the belt, initialization and the whole cell."""

    @property
    def job(self) -> str | None:
        """Id of the job."""

    @property
    def item(self) -> str | None:
        """Id of the item."""

    @property
    def task(self) -> str | None:
        """Id of the task in its script."""

    @property
    def name(self) -> str:
        """Task constant."""

    @property
    def component(self) -> str:
        """Component that the task is for."""

    @property
    def action(self) -> str:
        """Action of the component."""

    @property
    def attempt(self) -> int:
        """Number of the attempt that failed, from 1."""

    @property
    def attempts(self) -> int:
        """Attempts that the script allows."""

    @property
    def reason(self) -> str:
        """Why, in one word."""

    @property
    def message(self) -> str:
        """Words of the server, or of the orchestrator."""

    @property
    def controller_said(self) -> str:
        """Text of the controller's own result."""

    @property
    def topic_says(self) -> str:
        """End of a goal without a result, by the status topic of its action."""


class NumberedHold(HoldFacts, Protocol):
    """A hold that knows its own number."""

    @property
    def id(self) -> str:
        """Number of the hold, by which it is answered."""


def hold_words(hold: HoldFacts) -> str:
    """Say where something is held, what, and why."""
    attempt = attempt_words(hold.attempt, hold.attempts)
    named = ', '.join(filter(None, (_section(hold), _subject(hold), attempt)))
    return f'{f"{named}: " if named else ""}{held_words(hold)}'


def hold_name(hold: NumberedHold) -> str:
    """Name a hold: its number, what is held, and why; of the whole cell with its message."""
    what = hold.task or hold.item
    if what:
        return f'hold {hold.id} ({what}: {hold.reason})'
    return f'hold {hold.id} ({", ".join(filter(None, (hold.reason, one_line(hold.message))))})'


def hold_wait_words(holds: Iterable[NumberedHold]) -> str:
    """Say that something waits until holds are answered; several by their numbers alone."""
    named = tuple(holds)
    if len(named) == 1:
        return f'waiting for an answer to {hold_name(named[0])}'
    *others, last = (hold.id for hold in named)
    return f'waiting for answers to holds {", ".join(others)} and {last}'


def held_words(hold: HoldFacts) -> str:
    """Say why something is held, without saying what and where."""
    return why_words(hold.reason, hold.message, hold.controller_said, hold.topic_says)


def why_words(reason: str, message: str, controller_said: str = '', topic_says: str = '') -> str:
    """Say why something failed or is held.

    :param reason: in one word
    :param message: of the server or the program
    :param controller_said: text of the controller's own result
    :param topic_says: end of a goal without a result, by the status topic
    """
    said = [f'the controller says: {controller_said}'] if controller_said else []
    listed = [f'the status topic says: {topic_says}'] if topic_says else []
    words = '; '.join(filter(None, map(one_line, (*said, message, *listed))))
    return f'{reason} ({words})' if words else reason


def _section(hold: HoldFacts) -> str:
    return f'section {hold.section}' if hold.section else ''


def _subject(hold: HoldFacts) -> str:
    about = hold.item or hold.job or ''
    if not hold.task:
        return about
    name = f' ({hold.name})' if hold.name else ''
    of_what = f' of {about}' if about else ''
    where = f' at {hold.component} ({hold.action})' if hold.component else ''
    return f'{hold.task}{name}{of_what}{where}'


def again_words(round_: int, attempt: int) -> str:
    """Say which round of a repeat, from 0, and which attempt it is; empty: the first of both."""
    words = [f'round {round_ + 1}'] if round_ else []
    return ', '.join([*words, f'attempt {attempt}'] if attempt > 1 else words)


def attempt_words(attempt: int, attempts: int) -> str:
    """Say which attempt failed; one that an operator added is beyond those allowed."""
    if not attempt:
        return ''
    return f'attempt {attempt} of {attempts}' if attempt <= attempts else f'attempt {attempt}'
