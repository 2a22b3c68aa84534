"""The record of an item as a story: chapters of what happened, in words, in the order of time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_orchestrator.model.by import named
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.hold_words import again_words, why_words
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.view.report.intervals import Span, covered_s
from bt_orchestrator.view.report.item.history import (
    CONTINUED,
    FAILED,
    MARKED_DONE,
    RUNNING,
    SKIPPED,
    SUCCEEDED,
    Attempt,
    AtWork,
    ClockSet,
    Decision,
    Held,
    ItemHistory,
    Restart,
    Waited,
)
from bt_orchestrator.view.report.tables import shown

TASK, HOLD, DECISION, RESTART, END = 'task', 'hold', 'decision', 'restart', 'end'
CLOCK = 'clock'
"""Kinds of entries."""

NOT_TOLD = 'waiting, the journal does not tell for what'

HOW: Mapping[str, str] = {
    'packed': 'packed',
    'rejected': 'rejected',
    'by_hand': 'taken off by hand',
    'missing': 'never placed',
    '': 'on the line',
}
"""How an item ended, in words."""

LEAST_REST_S = 0.05
"""Less is the time that the program needs."""

_POLICIES = {
    OnFailure.CONTINUE.value: 'the item went on without it',
    OnFailure.REJECT.value: 'the item was rejected',
    OnFailure.ABORT_JOB.value: 'the job was aborted',
}


class Detail(NamedTuple):
    """Something that belongs to an entry."""

    name: str
    text: str


@dataclass
class Entry:
    """One thing that happened."""

    time: float
    kind: str
    outcome: str
    """Of an attempt, or of the item; empty: it has none."""
    what: str
    where: str = ''
    """Component and task constant."""
    words: str = ''
    """How it ended, or why."""
    seconds: float | None = None
    """How long it took; None: no time, or it has not ended."""
    waited: list[Waited] = field(default_factory=list)
    details: list[Detail] = field(default_factory=list)


@dataclass
class Chapter:
    """The events while the item stood at one place."""

    title: str
    since: float
    until: float | None
    beside: str
    """The content of the other slots; empty: nothing, or not known."""
    entries: list[Entry] = field(default_factory=list)


class TimeUse(NamedTuple):
    """The use of some of the time of an item."""

    words: str
    kind: str
    """A value of `model.wait.WaitKind`; `work`: a task ran; empty: not known."""
    seconds: float


def chapters(history: ItemHistory) -> list[Chapter]:
    """Return the story of an item."""
    entries = sorted(_entries(history), key=lambda record: (record.time, _rank(record)))
    places = list(_places(history))
    if not places:
        begin = entries[0].time if entries else 0.0
        places = [Chapter('', begin, history.ended, '')]
    for entry in entries:
        begun = [place for place in places if place.since <= entry.time]
        (begun[-1] if begun else places[0]).entries.append(entry)
    return places


def wait_words(waited: Waited) -> str:
    """Say what something waited for."""
    return waited.words or NOT_TOLD


def duration(seconds: float) -> str:
    """Write how long something took: 0.25 s, 12.5 s, 2 min 5 s, 3 h 2 min."""
    if seconds < 1.0:
        return f'{seconds:.2f} s' if seconds >= 0.005 else '0 s'
    if seconds < 60:
        return f'{seconds:.1f} s'
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f'{hours} h {minutes} min'
    return f'{minutes} min {rest} s' if rest else f'{minutes} min'


def time_uses(history: ItemHistory) -> list[TimeUse]:
    """Return what the time of an item was used for: its work, then its waits, the longest first.

    Each moment counts once: while one of two parallel tasks runs, the item does not wait.
    """
    taken = history.work
    worked_s = covered_s(taken)
    waited: dict[tuple[str, str], float] = {}
    waits = {*history.idle, *(waited for task in history.tasks for waited in task.waited)}
    for wait in sorted(waits, key=lambda w: w.start):
        span = Span(wait.start, wait.end)
        more_s = covered_s([*taken, span]) - covered_s(taken)
        key = (wait_words(wait), wait.kind)
        waited[key] = waited.get(key, 0.0) + more_s
        taken.append(span)
    uses = [TimeUse(*key, seconds) for key, seconds in waited.items() if seconds > 0]
    uses.sort(key=lambda use: -use.seconds)
    return [TimeUse('worked on', 'work', worked_s), *uses, *_rest(history, covered_s(taken))]


def worked_s(history: ItemHistory) -> float:
    """Return for how long at least one task of an item ran."""
    return covered_s(history.work)


def _rest(history: ItemHistory, told_s: float) -> Iterator[TimeUse]:
    """Yield the time that belongs to no task: before the end, or with records that are gone."""
    if history.started is None or history.ended is None:
        return
    seconds = history.ended - history.started - told_s
    if seconds >= LEAST_REST_S:
        yield TimeUse('neither worked on nor waiting for a task', '', seconds)


# --- entries ------------------------------------------------------------------------------------

_RANKS = {CLOCK: 1, RESTART: 1, HOLD: 2, DECISION: 3, TASK: 4, END: 5}


def _rank(entry: Entry) -> int:
    """Return what comes first of one moment; what failed without an attempt is held then."""
    is_unsent = entry.kind == TASK and entry.outcome == FAILED and not entry.where
    return 0 if is_unsent else _RANKS[entry.kind]


def _entries(history: ItemHistory) -> Iterator[Entry]:
    yield from map(_task, history.tasks)
    yield from map(_hold, history.holds)
    yield from map(_decision, history.decisions)
    yield from map(_restart, history.restarts)
    yield from map(_clock_set, history.clock_set)
    if history.ended is not None:
        words = history.rejected if history.how == 'rejected' else ''
        yield Entry(history.ended, END, history.how, HOW[history.how], words=words)


def _task(attempt: Attempt) -> Entry:
    time = attempt.started if attempt.started is not None else attempt.ended
    again = again_words(attempt.round, attempt.attempt)
    return Entry(
        time or 0.0,
        TASK,
        attempt.outcome,
        f'{attempt.task}, {again}' if again else attempt.task,
        where=' '.join(filter(None, (attempt.component, attempt.name))),
        words=_outcome(attempt),
        seconds=attempt.seconds,
        waited=attempt.waited,
        details=list(_details(attempt)),
    )


def _outcome(attempt: Attempt) -> str:
    if attempt.outcome == SUCCEEDED:
        return 'done'
    if attempt.outcome == RUNNING:
        return 'not ended yet'
    if attempt.outcome == SKIPPED:
        return f'skipped: {attempt.reason}'
    if attempt.outcome == MARKED_DONE:
        return 'marked done by an operator'
    if attempt.outcome == CONTINUED:
        return _POLICIES.get(attempt.reason, attempt.reason)
    return f'failed: {why_words(attempt.reason, attempt.message)}'  # the rest in details


def _details(attempt: Attempt) -> Iterator[Detail]:
    if attempt.args:
        yield Detail('arguments', _values(attempt.args))
    if attempt.controller_said:
        yield Detail('the controller says', one_line(attempt.controller_said))
    if attempt.last_feedback:
        yield Detail('last feedback', attempt.last_feedback)
    if attempt.topic_says:
        yield Detail('the status topic says', attempt.topic_says)
    if attempt.results:
        name = 'refused' if attempt.outcome == FAILED else 'results'
        yield Detail(name, _values(attempt.results))
    if attempt.beside:
        yield Detail('at work at the same time', _at_work(attempt.beside))
    if attempt.adopted:
        yield Detail('restart', 'the goal was taken over after a restart')
    if attempt.resent:
        yield Detail('restart', 'its goal was sent again: the server did not know it')
    if attempt.cancelled:
        yield Detail('cancelled', attempt.cancelled.replace('_', ' '))


def _values(mapping: Mapping[str, Any]) -> str:
    return ', '.join(f'{name}: {shown(value)}' for name, value in mapping.items())


def _at_work(others: Iterable[AtWork]) -> str:
    named_once = dict.fromkeys(
        f'{other.component} {other.name} ({other.item})'
        if other.item
        else f'{other.component} {other.name}'
        for other in others
    )
    return ', '.join(named_once)


def _hold(held: Held) -> Entry:
    about = held.task or ('the whole cell' if held.of_cell else '')
    what = f'hold {held.id}, {about}' if about else f'hold {held.id}'
    seconds = None if held.ended is None else held.ended - held.time
    return Entry(held.time, HOLD, '', what, words=held.words, seconds=seconds)


def _decision(decision: Decision) -> Entry:
    who = named(decision.who, decision.known) if decision.known else decision.who or 'somebody'
    role = f', {decision.role},' if decision.role else ''
    about = (
        f' of hold {decision.hold}'
        if decision.hold
        else (' for the whole cell' if decision.of_cell else '')
    )
    return Entry(
        decision.time,
        DECISION,
        '',
        f'{who}{role} decided {decision.what}{about}',
        words=decision.reason,
    )


def _restart(restart: Restart) -> Entry:
    silent = duration(max(0.0, restart.time - restart.silent_since))
    words = restart.words or 'it went on from its last event'
    what = f'the orchestrator was started again, {silent} after its last event'
    return Entry(restart.time, RESTART, '', what, words=words)


def _clock_set(change: ClockSet) -> Entry:
    way = 'back' if change.seconds < 0 else 'forward'
    what = f'the clock was set {way} by {duration(abs(change.seconds))}'
    return Entry(change.time, CLOCK, '', what, words='times here go on as if it had not been set')


def _places(history: ItemHistory) -> Iterator[Chapter]:
    for number, stay in enumerate(history.stays):
        since = stay.since
        if number == 0 and history.started is not None:
            since = history.started
        beside = ', '.join(
            f'section {neighbour.section}: {neighbour.item}' for neighbour in stay.beside
        )
        yield Chapter(f'Section {stay.section}', since, stay.until, beside)
