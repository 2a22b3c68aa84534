"""Title and legend of the drawing of a line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from bt_orchestrator.view.drawing.card import (
    ITEM_FILL,
    OFF_BELT,
    ROUND_FILL,
    ZONE_FILLS,
    Sheet,
    belt_words,
)
from bt_orchestrator.view.drawing.label import (
    BAR_FILL,
    FAINT,
    FLAG,
    INK,
    PAPER,
    Entry,
    Label,
    Text,
    wrapped,
)
from bt_orchestrator.view.drawing.mark import headlines, legend_rows

LINE = 18.0
LEGEND_LINE_HEIGHT = 15.0
SAMPLE_WIDTH = 80.0
LETTER = 5.2
TITLE_WIDTH = 600.0
LEGEND_WIDTH = 440.0
"""Points."""
TITLE_COLUMNS = 85
"""Letters of a line below the title."""


def title(sheet: Sheet) -> Label:
    """Return what a drawing is of: script, cell, and what an order may set."""
    script, conveyor, say = sheet.script, sheet.cell.conveyor, sheet.wording.say
    of = say('for cell {cell}, {count} sections', cell=sheet.cell.name, count=conveyor.sections)
    rows = [
        Text(script.name, 22, bold=True),
        Text(of, 12),
    ]
    if sheet.pace is not None:
        rows += [Text(line, 12) for line in wrapped(str(sheet.pace), TITLE_COLUMNS)]
    for parameter in script.params.values():
        default = (
            say('required')
            if parameter.required
            else say('default {value}', value=parameter.default)
        )
        name = say('parameter {name}', name=parameter.name)
        text = f'{name}: {parameter.type}, {default}'
        rows.append(Text(text, 11, FAINT))
    if script.quantity is not None:
        rows.append(Text(say('quantity: default {count}', count=script.quantity), 11, FAINT))
    limit = script.hold_after or sheet.cell.hold_after
    if limit is not None:
        held = say(
            'holds after {rejects} rejects within {of} items', rejects=limit.rejects, of=limit.of
        )
        rows.append(Text(held, 11, FAINT))
    if sheet.state is not None:
        rows += headlines(sheet.state, sheet.wording)
    height = 16 + LINE * len(rows)
    return Label(tuple((Entry((row,), width=TITLE_WIDTH),) for row in rows), height=height)


def legend(sheet: Sheet) -> Label:
    """Explain the marks that this drawing has."""
    rows: list[tuple[Entry, ...]] = [
        (Entry((Text(sheet.wording.say('Legend'), 11, bold=True),), span=2),)
    ]
    width = _sample_width(sheet)
    for sample, meaning in _entries(sheet):
        words = Entry((Text(meaning, 9),), width=LEGEND_WIDTH - SAMPLE_WIDTH)
        rows.append((replace(sample, width=width), words))
    height = 6 + LEGEND_LINE_HEIGHT * len(rows)
    return Label(tuple(rows), 1, PAPER, height=height)


def legend_width(sheet: Sheet) -> float:
    """Return how wide the legend is: words of a mark are longer in some languages."""
    return LEGEND_WIDTH + _sample_width(sheet) - SAMPLE_WIDTH


def _sample_width(sheet: Sheet) -> float:
    longest = max(len(sample.texts[0].text) for sample, _ in _entries(sheet))
    return max(SAMPLE_WIDTH, LETTER * longest)


def _entries(sheet: Sheet) -> Iterator[tuple[Entry, str]]:
    script, say = sheet.script, sheet.wording.say
    yield (
        _plain(say('task')),
        say('id, task constant, action, arguments; holds if it fails, unless it says more'),
    )
    item = _sample(say('{count} item', count='+1'), ITEM_FILL)
    yield item, say('places an item on the belt; \u22121 takes it out')
    yield _plain('\u2192'), say('one after the other; side by side: at the same time')
    if _off_belt(sheet):
        frame = _plain(say('dashed frame'))
        yield frame, say('{when}: need not wait for the belt to rest', when=say(OFF_BELT))
    if script.dependencies:
        yield (
            _plain(say('- - \u25b6 flag'), FLAG),
            say('\u25b2 sets it, waits while it is full; \u25bc takes it, waits while it is 0'),
        )
    if script.zones:
        zone = say('tasks of one zone never run at the same time')
        yield _sample(say('\u25a0 zone'), ZONE_FILLS[0]), zone
    if script.repeats:
        again = say('tasks that are all done again where a verdict refuses the result of one')
        yield _sample('\u21bb', ROUND_FILL), again
    if sheet.pace is not None and sheet.pace.limit.tasks:
        yield (
            _plain(say('\u25c6 limits')),
            say('these, one after the other for each item, decide how fast the line is'),
        )
    belt = say('the belt; it moves when every section is at the end of its list')
    yield _plain(say('grey line')), belt
    if any(tasks.turn_steps < len(tasks.steps) for tasks in script.sections.values()):
        yield (
            _plain(say('belt released'), PAPER, BAR_FILL),
            say('or at this bar, if the list has one'),
        )
    if sheet.state is not None:
        if sheet.state.belt_moves:
            yield _plain(say('dashed line')), say('the belt while it moves')
        for sample, fill, meaning in legend_rows(sheet.state, sheet.wording):
            yield _sample(sample, fill), meaning


def _plain(text: str, colour: str = INK, fill: str = '') -> Entry:
    return Entry((Text(text, 9, colour, bold=True),), fill=fill, width=SAMPLE_WIDTH)


def _sample(text: str, fill: str) -> Entry:
    return Entry((Text(text, 9),), fill=fill, width=SAMPLE_WIDTH)


def _off_belt(sheet: Sheet) -> bool:
    return any(
        belt_words(tasks, step, task)
        for tasks in sheet.script.sections.values()
        for step in tasks.steps
        for task in step.tasks
    )
