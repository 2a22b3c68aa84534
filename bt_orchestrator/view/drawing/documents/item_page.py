"""The record of items as a document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bt_orchestrator.view.drawing.documents.html import HERE, Html, Times, document, program
from bt_orchestrator.view.drawing.documents.item_strip import item_strip
from bt_orchestrator.view.drawing.gantt_page import gantt_svg
from bt_orchestrator.view.report.item.history import FAILED, ItemHistory
from bt_orchestrator.view.report.item.story import (
    DECISION,
    HOW,
    TASK,
    Chapter,
    Entry,
    chapters,
    duration,
    time_uses,
    wait_words,
    worked_s,
)
from bt_orchestrator.view.report.tables import shown

PLOT = 860.0
"""Width of the time line, in pixels: a page of paper shows it whole."""

_LOOKS = {'packed': 'good', 'rejected': 'bad', 'by_hand': 'warn', 'missing': 'warn', '': ''}
_SIGNS = {
    'packed': '\u2713',
    'rejected': '\u2717',
    'by_hand': '\u2197',
    'missing': '\u2205',
    '': '\u25b6',
}
_MARKS = {
    'succeeded': '\u2713',
    'failed': '\u2717',
    'running': '\u25b6',
    'skipped': '\u21b7',
    'marked_done': '\u2713',
    'continued': '\u2717',
    'hold': '\u25b2',
    'decision': '\u25a0',
    'restart': '\u21bb',
    'end': '\u25cf',
}


@dataclass(frozen=True)
class Source:
    """Where a record comes from, for its last lines."""

    journal: str
    """In words, as in `the journal cell.sqlite3`."""
    made: float
    """When the document was made, seconds since the epoch."""
    lacks: Sequence[str] = ()
    """The damaged parts of the journal, in sentences."""
    times: Times = HERE


def item_page(items: Sequence[ItemHistory], source: Source, title: str) -> str:
    """Return a document with the records of items; several begin with a list of them."""

    def write(page: Html) -> None:
        if len(items) != 1:
            _list(page.add('article'), items, source, title)
        for item in items:
            _record(page.add('article', class_='record', id=item.item), item, source)

    return document(title, write)


def _list(sheet: Html, items: Sequence[ItemHistory], source: Source, title: str) -> None:
    sheet.add('p', 'Item records', class_='kind')
    sheet.add('h1', title)
    sheet.add('p', f'{len(items)} items', class_='sub')
    _lacks(sheet, source)
    table = sheet.add('table', style='margin-top: 20px')
    row = table.add('thead').add('tr')
    for name in ('item', 'serial', 'end', 'from', 'to', 'failed attempts'):
        row.add('th', name, class_='number' if name.startswith('failed') else '')
    body = table.add('tbody')
    for item in items:
        row = body.add('tr')
        row.add('td').add('a', item.item, href=f'#{item.item}')
        row.add('td', item.serial)
        row.add('td', f'{_SIGNS[item.how]} {HOW[item.how]}')
        for time in (item.started, item.ended):
            row.add('td', '' if time is None else source.times.day(time), class_='time')
        row.add('td', str(_failed(item)), class_='number')
    _foot(sheet, source)


def _record(sheet: Html, item: ItemHistory, source: Source) -> None:
    _head(sheet, item, source.times)
    _lacks(sheet, source)
    if item.started is None:
        sheet.add(
            'p', 'The journal does not have the beginning of this item any more.', class_='notice'
        )
    _tiles(sheet, item)
    _facts(sheet, item)
    if item.started is not None:
        sheet.add('h2', 'Time line')
        svg = gantt_svg(item_strip(item, source.made), PLOT)
        sheet.add('div', class_='picture').draw(svg)
        sheet.add('h2', 'Where the time went')
        _times(sheet, item)
    sheet.add('h2', 'What happened')
    for chapter in chapters(item):
        _chapter(sheet, chapter, source.times)
    _foot(sheet, source)


def _head(sheet: Html, item: ItemHistory, times: Times) -> None:
    head = sheet.add('header', class_='head')
    names = head.add('div')
    names.add('p', 'Item record', class_='kind')
    names.add('h1', item.serial or item.item)
    about = [f'item {item.item}' if item.serial else '', f'order {item.job}']
    if item.started is not None:
        when = times.period(item.started, item.ended)
        about.append(f'{when}, {times.name(item.started)}')
    names.add('p', ' \u00b7 '.join(filter(None, about)), class_='sub')
    look = 'warn' if item.how == 'packed' and item.nonconforming else _LOOKS[item.how]
    words = f'{_SIGNS[item.how]} {HOW[item.how]}'
    words += ', nonconforming' if item.nonconforming else ''
    head.add('p', words, class_=f'badge {look}'.strip())
    if item.rejected:
        sheet.add('p', f'Rejected: {item.rejected}', class_='notice bad')
    if item.nonconforming:
        tasks = ', '.join(dict.fromkeys(item.nonconforming))
        sheet.add('p', f'Let pass although not done well: {tasks}', class_='notice')


def _lacks(sheet: Html, source: Source) -> None:
    if source.lacks:
        sheet.add('p', f'Not everything is here: {"; ".join(source.lacks)}', class_='notice bad')


def _tiles(sheet: Html, item: ItemHistory) -> None:
    tiles = sheet.add('div', class_='tiles')
    if item.started is not None and item.ended is not None:
        _tile(tiles, duration(item.ended - item.started), 'on the line')
    _tile(tiles, duration(worked_s(item)), 'worked on')
    attempts = [task for task in item.tasks if task.started is not None]
    _tile(tiles, str(len(attempts)), 'attempts')
    failed = _failed(item)
    _tile(tiles, str(failed), 'of them failed', is_bad=bool(failed))
    _tile(tiles, str(len(item.holds)), 'holds', is_bad=bool(item.holds))
    if item.restarts:
        _tile(tiles, str(len(item.restarts)), 'restarts of the node', is_bad=True)


def _tile(tiles: Html, number: str, words: str, *, is_bad: bool = False) -> None:
    tile = tiles.add('div', class_='tile bad' if is_bad else 'tile')
    tile.add('b', number)
    tile.add('span', words)


def _facts(sheet: Html, item: ItemHistory) -> None:
    facts = sheet.add('dl', class_='facts')
    version = '' if item.recipe_version is None else f', version {item.recipe_version}'
    quantity = f', {item.quantity} items' if item.quantity else ''
    digest = f' (digest {item.digest[:16]})' if item.digest else ''
    for name, text in (
        ('Item', item.item if item.serial else ''),
        ('Order', f'{item.job}{quantity}'),
        ('First piece', item.first_piece),
        ('Recipe', f'{item.recipe}{version}' if item.recipe else ''),
        ('Script', f'{item.script}{digest}' if item.script else ''),
        *((f'Parameter {name}', shown(value)) for name, value in item.params.items()),
        *((f'Lot of {name}', lot) for name, lot in item.lots.items()),
    ):
        if text:
            facts.add('dt', name)
            facts.add('dd', text)


def _times(sheet: Html, item: ItemHistory) -> None:
    uses = time_uses(item)
    longest = max([use.seconds for use in uses], default=0.0) or 1.0
    body = sheet.add('table').add('tbody')
    for use in uses:
        row = body.add('tr')
        row.add('td', use.words)
        row.add('td', duration(use.seconds), class_='number')
        look = 'busy' if use.kind == 'work' else ''
        bar = row.add('td', class_='bar')
        bar.add('i', class_=look, style=f'width: {100 * use.seconds / longest:.1f}%')


def _failed(item: ItemHistory) -> int:
    return sum(task.outcome == FAILED for task in item.tasks)


# --- the story ----------------------------------------------------------------------------------


def _chapter(sheet: Html, chapter: Chapter, times: Times) -> None:
    part = sheet.add('section', class_='chapter')
    if chapter.title:
        head = part.add('header')
        head.add('h3', chapter.title)
        until = '' if chapter.until is None else f' to {times.clock(chapter.until)}'
        head.add('p', f'{times.clock(chapter.since)}{until}')
        if chapter.beside:
            head.add('p', f'beside it stood {chapter.beside}')
    table = part.add('table', class_='story')
    row = table.add('thead').add('tr')
    for name in ('began', 'waited before', 'task', 'took', 'how it ended'):
        row.add('th', name, class_='number' if name == 'took' else '')
    body = table.add('tbody')
    for entry in chapter.entries:
        _entry(body, entry, times)


def _entry(body: Html, entry: Entry, times: Times) -> None:
    row = body.add('tr', class_=f'is-{entry.kind} {entry.outcome}'.strip())
    row.add('td', times.clock(entry.time), class_='time')
    if entry.kind == TASK:
        waited = row.add('td', class_='waited')
        for wait in entry.waited:
            line = waited.add('div')
            line.add('b', duration(wait.seconds))
            line.say(f' {wait_words(wait)}')
    what = row.add('td', class_='what', colspan=1 if entry.kind == TASK else 2)
    mark = _MARKS.get(entry.outcome if entry.kind == TASK else entry.kind, '')
    if entry.kind != TASK:
        what.add('span', mark, class_='mark', style='display: inline-block')
    what.add('b', entry.what)
    if entry.where:
        what.add('span', entry.where)
    took = '' if entry.seconds is None else duration(entry.seconds)
    row.add('td', took, class_='number')
    words = row.add('td', class_='words')
    if entry.words:
        line = words.add('p')
        if entry.kind == TASK:
            line.add('span', mark, class_='mark')
        line.add('span', entry.words, class_='quote' if entry.kind == DECISION else '')
    for detail in entry.details:
        more = words.add('p', class_='more')
        more.add('b', f'{detail.name} ')
        more.say(detail.text)


def _foot(sheet: Html, source: Source) -> None:
    times = source.times
    made = f'Made {times.day(source.made)} from {source.journal} by {program()}'
    whose = 'of this computer, ' if times.zone is None else 'of '
    sheet.add('footer', f'{made}. Times are those {whose}{times.name(source.made)}.')
