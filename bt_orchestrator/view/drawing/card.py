"""The card of one task: the essentials, and the rest in a tooltip."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.proof.pace import Pace
from bt_orchestrator.model.script import Repeat, RunsFor, Script, SectionList, Step, Task
from bt_orchestrator.view.drawing.label import (
    CARD_COLUMNS,
    FAINT,
    PAPER,
    Entry,
    Label,
    Text,
    wrapped,
)
from bt_orchestrator.view.drawing.line_state import LineState
from bt_orchestrator.view.drawing.mark import CARD_HEIGHT, about_state, card_state
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording

MOST_LINES = 3
"""Lines of one argument on a card; the tooltip has all of it."""

CARD_WIDTH = 196
BADGE_WIDTH = 56
"""Points."""

ID_COLUMNS = 17
NAME_COLUMNS = 27
ROUND_COLUMNS = 38
"""As CARD_COLUMNS, in their larger letters."""

ITEM_FILL = '#dbeafe'
ZONE_FILLS = ('#fde68a', '#bbf7d0', '#fbcfe8', '#ddd6fe')
"""Light enough for black text, and for paper; a zone's name is always beside its colour."""

ROUND_FILL = '#e0e7ff'

OFF_BELT = 'while the belt moves'
NEEDS_NO_BELT = 'does not need the belt'
AT_REST = 'must be at rest'

POLICY: Mapping[OnFailure, str] = {
    OnFailure.HOLD: 'hold, an operator decides',
    OnFailure.CONTINUE: 'continue',
    OnFailure.REJECT: 'reject the item',
    OnFailure.ABORT_JOB: 'abort the job',
}
RUNS_FOR: Mapping[RunsFor, str] = {
    RunsFor.GOOD: 'good items',
    RunsFor.REJECTED: 'rejected items only',
    RunsFor.ALL: 'good and rejected items',
}


@dataclass(frozen=True)
class Sheet:
    """The subject of a drawing: one script in its cell, and its state there."""

    script: Script
    cell: Cell
    state: LineState | None = None
    """The line at work; None: the script alone."""
    pace: Pace | None = None
    """How fast the line is with the script; None: not told."""
    wording: Wording = ENGLISH
    is_bare: bool = False
    """Without title and legend: what is around the drawing says that."""

    def limits(self, task: Task) -> bool:
        """Tell whether a task is part of what limits the line."""
        return self.pace is not None and task.id in self.pace.limit.tasks

    def zone_fill(self, zone: str) -> str:
        """Return the colour of a zone; with many zones colours repeat, names do not."""
        names = [other.name for other in self.script.zones]
        return ZONE_FILLS[names.index(zone) % len(ZONE_FILLS)]


def card(sheet: Sheet, task: Task, belt: str = '') -> Label:
    """Return the card of a task; it is at most as high as it says.

    :param belt: how it relates to the moving belt, if it does not require the belt to rest
    """
    title, what = _title(task), list(_what(task))
    rows = [_head(sheet, task, title), _wide(what)]
    options = [sheet.wording.say(belt)] if belt else []
    options += [text for option in _options(sheet, task) for text in wrapped(option)]
    if options:
        rows.append(_wide([Text(text, 9, italic=True) for text in options]))
    marks = list(_marks(sheet, task))
    rows += [_wide([Text(text, 9)], fill) for text, fill in marks]
    texts, blocks = len(what) + len(options), len(rows)
    height = 15 * len(title) + 11 * texts + 4 * blocks + 11 * len(marks) + 4.0
    border = 1
    if sheet.state is not None:
        now = sheet.state.task(task.id)
        rows.insert(0, _wide(card_state(now, sheet.wording), now.mark.fill))
        height += CARD_HEIGHT
        border = 3 if now.mark.needs_eyes else 1
    return Label(tuple(rows), border, PAPER, dashed=bool(belt), height=height)


def belt_words(tasks: SectionList, step: Step, task: Task) -> str:
    """Say how a task that does not require the conveyor relates to it (semantics 3.3 to 3.8)."""
    if task.requires_conveyor:
        return ''
    number = tasks.steps.index(step)
    leads = not any(earlier.requires_conveyor for earlier in tasks.steps[: number + 1])
    return OFF_BELT if leads or number >= tasks.turn_steps else NEEDS_NO_BELT


def details(sheet: Sheet, task: Task, belt: str = '') -> Sequence[str]:
    """Return everything that is known about a task, line by line."""
    now = () if sheet.state is None else about_state(sheet.state.task(task.id), sheet.wording)
    return [*now, *_details(sheet, task, belt)]


def arguments(value: Any) -> str:
    """Write an argument as a script does: references as written, true and not True."""
    if isinstance(value, Mapping):
        return '{' + ', '.join(f'{key}: {arguments(v)}' for key, v in value.items()) + '}'
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(arguments(member) for member in value)}]'
    if isinstance(value, bool):
        return str(value).lower()
    return str(value)


def seconds(value: float | None, wording: Wording = ENGLISH) -> str:
    """Write a time limit."""
    if value is None:
        return wording.say('no time limit')
    return wording.say('at most {seconds} s', seconds=f'{value:g}')


def _title(task: Task) -> list[str]:
    return wrapped(task.id, ID_COLUMNS)


def _head(sheet: Sheet, task: Task, title: Sequence[str]) -> tuple[Entry, ...]:
    words = [Text(text, 12, bold=True) for text in title]
    if not task.qty_change:
        return _wide(words)
    return Entry(tuple(words), width=CARD_WIDTH - BADGE_WIDTH), _badge(sheet, task)


def _badge(sheet: Sheet, task: Task) -> Entry:
    count = f'{task.qty_change:+d}'.replace('-', '\u2212')
    text = Text(sheet.wording.say('{count} item', count=count), bold=True)
    return Entry((text,), centred=True, fill=ITEM_FILL, width=BADGE_WIDTH)


def _wide(texts: Iterable[Text], fill: str = '') -> tuple[Entry, ...]:
    return (Entry(tuple(texts), fill=fill, span=2, width=CARD_WIDTH),)


def _what(task: Task) -> Iterator[Text]:
    for text in wrapped(task.name, NAME_COLUMNS):
        yield Text(text)
    for text in wrapped(task.action):
        yield Text(text, 9, FAINT)
    for name, value in task.args.items():
        for text in _shortened(wrapped(f'{name}: {arguments(value)}')):
            yield Text(text, 9)


def _shortened(texts: list[str]) -> list[str]:
    if len(texts) <= MOST_LINES:
        return texts
    return [*texts[: MOST_LINES - 1], texts[MOST_LINES - 1][: CARD_COLUMNS - 2] + ' \u2026']


def _options(sheet: Sheet, task: Task) -> Iterator[str]:
    """Yield what differs from a plain task."""
    say = sheet.wording.say
    for setup, value in task.setup.items():
        yield say('needs {setup}: {value}', setup=setup, value=value)
    if task.change is not None:
        yield say('changes {setup} to {value}', setup=task.change.setup, value=task.change.value)
    if task.is_implied:
        yield say('unless it is so')
    elif task.once:
        yield say('once, until the cell stops')
    if task.condition is not None:
        yield sheet.wording.condition(str(task.condition))
    if task.fails_unless is not None:
        verdict = sheet.wording.condition(task.fails_unless.words)
        yield say('fails unless {condition}', condition=verdict)
    if task.identifies:
        yield say('reads the serial: {result}', result='.'.join(task.identifies))
    if task.runs_for is not RunsFor.GOOD:
        yield say('for {items}', items=say(RUNS_FOR[task.runs_for]))
    if task.retries:
        yield _retries(sheet, task)
    if task.on_failure is not OnFailure.HOLD:
        yield say('if it fails: {policy}', policy=say(POLICY[task.on_failure]))
    if task.timeout_s != sheet.cell.components[task.component].timeout_s:
        yield seconds(task.timeout_s, sheet.wording)
    if task.repeatable:
        yield say('repeatable')


def _retries(sheet: Sheet, task: Task) -> str:
    say = sheet.wording.say
    once = task.retries == 1
    times = say('retry once') if once else say('retry {count} times', count=task.retries)
    if not task.retry_delay_s:
        return times
    return say('{times}, after {seconds} s', times=times, seconds=f'{task.retry_delay_s:g}')


def _marks(sheet: Sheet, task: Task) -> Iterator[tuple[str, str]]:
    say = sheet.wording.say
    for flag in sheet.script.downstream_of.get(task.id, ()):
        yield say('\u25bc takes flag {flag}', flag=flag.flag), ''
    for flag in sheet.script.upstream_of.get(task.id, ()):
        yield say('\u25b2 sets flag {flag}', flag=flag.flag), ''
    for zone in sheet.script.zones_of.get(task.id, ()):
        yield say('\u25a0 zone {zone}', zone=zone), sheet.zone_fill(zone)
    if sheet.limits(task):
        yield say('\u25c6 limits the pace'), ''


def rounds_words(repeat: Repeat, wording: Wording) -> str:
    """Say how often the tasks of a repeat may be done again."""
    times, say = repeat.times, wording.say
    return (
        say('up to 1 more round') if times == 1 else say('up to {count} more rounds', count=times)
    )


def last_round(sheet: Sheet, tasks: Sequence[Task]) -> Label:
    """Say what follows where a verdict refuses the result of the last round (semantics 3.9).

    :param tasks: of a repeat
    """
    say = sheet.wording.say
    judged = [task for task in tasks if task.fails_unless is not None]
    policies = dict.fromkeys(task.on_failure for task in judged)
    if len(policies) == 1:
        sentences = [
            say('after the last round: {policy}', policy=say(POLICY[policy]))
            for policy in policies
        ]
    else:
        sentences = [
            say(
                'after the last round of {task}: {policy}',
                task=task.id,
                policy=say(POLICY[task.on_failure]),
            )
            for task in judged
        ]
    lines = [
        Text(text, 9, italic=True)
        for sentence in sentences
        for text in wrapped(sentence, ROUND_COLUMNS)
    ]
    return Label((_wide(lines),), height=11 * len(lines) + 4.0)


def _details(sheet: Sheet, task: Task, belt: str) -> Iterator[str]:
    component, say = sheet.cell.components[task.component], sheet.wording.say
    yield f'{task.id}: {task.name}'
    yield say('action: {action} ({type})', action=task.action, type=component.type)
    yield say('component: {component}', component=task.component)
    if component.state is not None:
        yield say('starts when: {condition}', condition=component.state)
    for name, value in task.args.items():
        yield say('argument {name}: {value}', name=name, value=arguments(value))
    if sheet.script.section_of(task.id):
        yield say('runs for: {items}', items=say(RUNS_FOR[task.runs_for]))
        yield say('belt: {how}', how=say(belt or AT_REST))
    if task.condition is not None:
        when = sheet.wording.condition(str(task.condition))
        yield say('condition: {condition}', condition=when)
    if task.fails_unless is not None:
        verdict = sheet.wording.condition(task.fails_unless.words)
        yield say('verdict: fails unless {condition}', condition=verdict)
    if task.identifies:
        yield say('serial of the item: {result}', result='.'.join(task.identifies))
    yield say('nominal time: {seconds} s', seconds=f'{component.duration_s(task.name):g}')
    yield say('time limit: {limit}', limit=seconds(task.timeout_s, sheet.wording))
    yield _retries(sheet, task) if task.retries else say('no retries')
    yield say('if it fails: {policy}', policy=say(POLICY[task.on_failure]))
    yield say('repeatable: yes') if task.repeatable else say('repeatable: no')
    repeat = sheet.script.repeat_of.get(task.id)
    if repeat is not None:
        yield f'\u21bb {", ".join(repeat.tasks)}: {rounds_words(repeat, sheet.wording)}'
    yield from (text for text, _ in _marks(sheet, task))
