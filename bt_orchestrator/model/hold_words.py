"""A hold in words: all sentences about holds are made here, from data.

`hold_words` is the complete text, for status, views, logs and pictures. `hold_name` is used inside
other sentences: refusals, waits, the stop reason.
"""

from __future__ import annotations

from collections.abc import Iterable

from bt_orchestrator.model.events import HoldRaised
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.model.words import sentence


def hold_words(hold: Hold | HoldRaised) -> str:
    """Say where something is held, what, and why."""
    attempt = attempt_words(hold.attempt, hold.attempts)
    named = ', '.join(filter(None, (_section(hold), _subject(hold), attempt)))
    return f'{f"{named}: " if named else ""}{held_words(hold)}'


def hold_name(hold: Hold) -> str:
    """Name a hold: its number, what is held, and why; of the whole cell with its message.

    The message about a run of rejects is too long for that.
    """
    what = hold.task or hold.item or hold.job
    if what:
        return sentence('hold_of', hold=hold.id, task=what, reason=hold.reason)
    message = one_line(hold.message)
    kind = 'hold_why' if message else 'hold_bare'
    return sentence(kind, hold=hold.id, reason=hold.reason, message=message)


def hold_wait_words(holds: Iterable[Hold]) -> str:
    """Say that something waits until holds are answered; several by their numbers alone."""
    named = tuple(holds)
    if len(named) == 1:
        return sentence('awaits_answer', held=hold_name(named[0]))
    *others, last = (hold.id for hold in named)
    return sentence('awaits_answers', others=', '.join(others), last=last)


def held_words(hold: Hold | HoldRaised) -> str:
    """Say why something is held, without saying what and where."""
    return why_words(hold.reason, hold.message, hold.controller_said, hold.topic_says)


def why_words(reason: str, message: str, controller_said: str = '', topic_says: str = '') -> str:
    """Say why something failed or is held.

    :param reason: in one word
    :param message: of the server or the program
    :param controller_said: text of the controller's own result
    :param topic_says: end of a goal without a result, by the status topic
    """
    quotes = [f'the controller says: {controller_said}'] if controller_said else []
    listed = [f'the status topic says: {topic_says}'] if topic_says else []
    words = '; '.join(filter(None, map(one_line, (*quotes, message, *listed))))
    return f'{reason} ({words})' if words else reason


def _section(hold: Hold | HoldRaised) -> str:
    return f'section {hold.section}' if hold.section else ''


def _subject(hold: Hold | HoldRaised) -> str:
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
