"""Title and legend of the drawing of a line."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.drawing.card import (
    ITEM_FILL,
    OFF_BELT,
    ROUND_FILL,
    ZONE_FILLS,
    Sheet,
    belt_words,
)
from bt_orchestrator.drawing.label import Entry, Label, Text, wrapped
from bt_orchestrator.drawing.mark import headlines, legend_rows
from bt_orchestrator.drawing.style import BAR_FILL, FAINT, FLAG, INK, PAPER

LINE = 18.0
LEGEND_LINE_HEIGHT = 15.0
SAMPLE_WIDTH = 80.0
TITLE_WIDTH = 600.0
LEGEND_WIDTH = 440.0
"""Points."""
TITLE_COLUMNS = 85
"""Letters of a line below the title."""


def title(sheet: Sheet) -> Label:
    """Return what a drawing is of: script, cell, and what an order may set."""
    script, conveyor = sheet.script, sheet.cell.conveyor
    rows = [
        Text(script.name, 22, bold=True),
        Text(f'for cell {sheet.cell.name}, {conveyor.sections} sections', 12),
    ]
    if sheet.pace is not None:
        rows += [Text(line, 12) for line in wrapped(str(sheet.pace), TITLE_COLUMNS)]
    for parameter in script.params.values():
        default = 'required' if parameter.required else f'default {parameter.default}'
        text = f'parameter {parameter.name}: {parameter.type}, {default}'
        rows.append(Text(text, 11, FAINT))
    if script.quantity is not None:
        rows.append(Text(f'quantity: default {script.quantity}', 11, FAINT))
    if sheet.state is not None:
        rows += headlines(sheet.state)
    height = 16 + LINE * len(rows)
    return Label(tuple((Entry((row,), width=TITLE_WIDTH),) for row in rows), height=height)


def legend(sheet: Sheet) -> Label:
    """Explain the marks that this drawing has."""
    rows: list[tuple[Entry, ...]] = [(Entry((Text('Legend', 11, bold=True),), span=2),)]
    for sample, meaning in _entries(sheet):
        rows.append((sample, Entry((Text(meaning, 9),), width=LEGEND_WIDTH - SAMPLE_WIDTH)))
    height = 6 + LEGEND_LINE_HEIGHT * len(rows)
    return Label(tuple(rows), 1, PAPER, height=height)


def _entries(sheet: Sheet) -> Iterator[tuple[Entry, str]]:
    script = sheet.script
    yield (
        _plain('task'),
        'id, task constant, action, arguments; holds if it fails, unless it says more',
    )
    yield _sample('+1 item', ITEM_FILL), 'places an item on the belt; \u22121 takes it out'
    yield _plain('\u2192'), 'one after the other; side by side: at the same time'
    if _off_belt(sheet):
        yield _plain('dashed frame'), f'{OFF_BELT}: need not wait for the belt to rest'
    if script.dependencies:
        yield (
            _plain('- - \u25b6 flag', FLAG),
            '\u25b2 sets it, waits while it is full; \u25bc takes it, waits while it is 0',
        )
    if script.zones:
        zone = 'tasks of one zone never run at the same time'
        yield _sample('\u25a0 zone', ZONE_FILLS[0]), zone
    if script.repeats:
        again = 'tasks that are all done again where a verdict refuses the result of one'
        yield _sample('\u21bb', ROUND_FILL), again
    if sheet.pace is not None and sheet.pace.limit.tasks:
        yield (
            _plain('\u25c6 limits'),
            'these, one after the other for each item, decide how fast the line is',
        )
    yield _plain('grey line'), 'the belt; it moves when every section is at the end of its list'
    if any(tasks.turn_steps < len(tasks.steps) for tasks in script.sections.values()):
        yield (
            _plain('belt released', PAPER, BAR_FILL),
            'or at this bar, if the list has one',
        )
    if sheet.state is not None:
        yield _plain('dashed line'), 'the belt while it moves'
        for sample, fill, meaning in legend_rows():
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
