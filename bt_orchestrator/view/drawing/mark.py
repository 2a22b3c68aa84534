"""The parts of a drawing that show state; they take the same room in every state."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator.model.words import AND
from bt_orchestrator.view.drawing.label import (
    CARD_COLUMNS,
    FAINT,
    SLOT_FILL,
    Entry,
    Label,
    Text,
    wrapped,
)
from bt_orchestrator.view.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.view.drawing.wording import Wording

REASON_LINES = 2
"""Room for a reason on a card, used or not: nothing moves from one drawing to the next."""

CARD_HEIGHT = 15.0 + 11 * REASON_LINES + 4
SLOT_HEIGHT = 61.0
"""Points."""

SLOT_LINES = 4
SLOT_COLUMNS = 28
"""Room in a slot, used or not; letters of its heading, which are bold."""

MOST_JOBS = 4
ELLIPSIS = ' \u2026'

NOT_BEGUN = 'not begun'

MEANINGS = {
    Mark.WAITING: 'is next, and says for what it waits',
    Mark.RUNNING: 'its goal is at the action server; thick frame',
    Mark.FAILED: 'its last attempt failed; thick frame',
    Mark.HELD: 'an operator has to answer: bt-orchestrator answer; thick frame',
    Mark.DONE: 'succeeded, in the cycle that is in hand',
    Mark.MARKED_DONE: 'failed, and an operator says that it is done',
    Mark.SKIPPED: 'not needed for this item, and not done',
    Mark.CONTINUED: 'failed, and the cycle goes on: the item is nonconforming',
    Mark.REJECTED: 'failed, and its item is rejected',
    Mark.ABORTED: 'failed, and its job is aborted',
}
"""The sentence of the legend for each mark."""


def card_state(mark: TaskMark, wording: Wording) -> Sequence[Text]:
    """Return what a card says of its task, above everything else."""
    reason = _cut(wrapped(_told(mark.reason)), REASON_LINES)
    return [_now(mark, wording), *(Text(text or ' ', 9) for text in reason)]


def about_state(mark: TaskMark, wording: Wording) -> Iterator[str]:
    """Yield how a task stands: the first lines about it."""
    yield wording.say('now: {state}', state=_text(mark, wording) or wording.say(NOT_BEGUN))
    if mark.reason:
        yield mark.reason


def slot_label(
    number: int, mark: SectionMark, width: float, height: float, wording: Wording
) -> Label:
    """Return a slot with what stands there, and what its section does."""
    say = wording.say
    there = f'({mark.slot})' if mark.is_empty_position else mark.slot or say('empty')
    work = next(_work(mark, wording), say('no cycle'))
    waits = '' if mark.works_on else ' '.join(mark.waiting[:1])
    texts = [Text(say('slot {number}: {there}', number=number, there=there), bold=True)]
    if len(texts[0].text) > SLOT_COLUMNS:
        shown = there if len(there) <= CARD_COLUMNS else f'\u2026{there[1 - CARD_COLUMNS :]}'
        texts = [Text(say('slot {number}', number=number), bold=True), Text(shown, 8)]
    fate = _fate(mark, wording)
    if fate or len(texts) == 1:
        texts.append(Text(fate or ' ', 9, bold=True))
    rest = SLOT_LINES - len(texts)
    if not mark.works_on and rest > 1:
        texts.append(Text(_cut(wrapped(work), 1)[0], 9))
        texts.append(Text(_cut(wrapped(waits), 1)[0] or ' ', 9, FAINT))
    else:
        texts += [Text(line.strip() or ' ', 9) for line in _cut(wrapped(work), rest)]
    inside = Entry(tuple(texts), centred=True, width=width, height=height)
    fill = Mark.REJECTED.fill if mark.is_rejected else SLOT_FILL
    return Label(((inside,),), 3 if mark.works_on else 0, fill)


def _fate(mark: SectionMark, wording: Wording) -> str:
    """Say what is wrong with what stands in a slot."""
    words = (
        (mark.is_empty_position, wording.say('empty position')),
        (mark.is_rejected, f'{Mark.REJECTED.sign} {wording.say("REJECTED")}'),
        (mark.is_nonconforming, wording.say('nonconforming')),
    )
    return ', '.join(word for is_so, word in words if is_so)


def about_slot(mark: SectionMark, wording: Wording) -> Iterator[str]:
    """Yield what is wrong with the item, and everything that the section waits for."""
    if fate := _fate(mark, wording):
        yield fate
    work = tuple(_work(mark, wording))
    yield from work or (wording.say('no cycle in hand'),)
    yield from mark.waiting


def _work(mark: SectionMark, wording: Wording) -> Iterator[str]:
    """Yield which items a section works on and is done with."""
    if mark.works_on:
        yield wording.say('works on {item}', item=mark.works_on)
    if mark.finished:
        yield wording.say('done with {item}', item=mark.finished)


def headlines(state: LineState, wording: Wording) -> list[Text]:
    """Return the lines below the title: always as many."""
    jobs = list(state.jobs)
    if len(jobs) > MOST_JOBS:
        more = len(jobs) - MOST_JOBS + 1
        jobs[MOST_JOBS - 1 :] = [wording.say('and {count} more jobs', count=more)]
    jobs += [' '] * (MOST_JOBS - len(jobs))
    return [
        Text(state.headline, 14, bold=True),
        *(Text(job, 11) for job in jobs),
    ]


def legend_rows(state: LineState, wording: Wording) -> Iterator[tuple[str, str, str]]:
    """Yield sample, its colour, and meaning of each mark that a drawing shows."""
    shown = {task.mark for task in state.tasks.values()}
    if any(section.is_rejected for section in state.sections.values()):
        shown.add(Mark.REJECTED)
    for mark, meaning in MEANINGS.items():
        if mark not in shown:
            continue
        word = wording.mark(mark)
        for part in (wording.say('failed, '), wording.say('is ')):
            word = word.removeprefix(part)
        yield f'{mark.sign} {word}', mark.fill, wording.say(meaning)


def _now(mark: TaskMark, wording: Wording) -> Text:
    if mark.mark is Mark.NEW:
        return Text(wording.say(NOT_BEGUN), 9, FAINT, italic=True)
    return Text(_text(mark, wording), 11, bold=True)


def _text(mark: TaskMark, wording: Wording) -> str:
    return ' '.join(filter(None, (mark.mark.sign, wording.mark(mark.mark), mark.words)))


def _told(reason: str) -> str:
    """Return the sentences of a reason that a card has room for: none is cut but the first."""
    whole = reason
    while len(wrapped(reason)) > REASON_LINES and AND in whole:
        whole = whole.rpartition(AND)[0]
        reason = whole + ELLIPSIS
    return reason


def _cut(texts: Sequence[str], count: int) -> list[str]:
    """Return so many lines; the last one says if there were more."""
    kept = list(texts[:count])
    if len(texts) > count:
        kept[-1] = kept[-1][: -len(ELLIPSIS)] + ELLIPSIS
    return kept + [''] * (count - len(kept))
