"""Reading the files of a plant: shifts, and reasons for stops."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from zoneinfo import ZoneInfo

from bt_orchestrator.model.plant.shifts import DAYS, EVERY_DAY, Hours, PlantReason, Shift, Shifts
from bt_orchestrator.script.fields import Fields, fields_of, file_fields
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.shifts.shifts_keys import (
    CLOCK_FORM,
    LANGUAGE_FORM,
    REASON,
    REASONS,
    SHIFT,
    SHIFTS,
    TARGET,
)
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import Scalar, found, quoted


def read_shifts(path: Path) -> Shifts:
    """Read a file of shifts.

    :raises Refused: with every mistake in it
    """
    return parse_shifts(read_text(path), str(path))


def parse_shifts(text: str, file: str) -> Shifts:
    """Read the text of a file of shifts; its name stands in the findings.

    :raises Refused: with every mistake in it
    """
    report = Report(file)
    fields = file_fields(text, SHIFTS, report)
    threshold = fields.seconds('micro_stop')
    shifts = Shifts(_shifts(fields), _zone(fields), _targets(fields), threshold)
    report.refuse()
    return shifts


def _shifts(fields: Fields) -> dict[str, Shift]:
    node = fields.mapping('shifts')
    shifts = {}
    for entry in (*node.entries, *node.repeated) if node else ():
        name = entry.key.text
        check_id(name, 'name of a shift', entry.key.place, fields.report)
        shift = fields_of(entry.value, SHIFT, fields.report)
        if shift is not None:
            shifts[name] = _shift(name, shift)
    if node is not None and not node.entries:
        fields.refuse('shifts', 'no shift is named', SHIFTS.by_name['shifts'].hint)
    return shifts


def _shift(name: str, fields: Fields) -> Shift:
    hours = _hours(fields)
    breaks = []
    for pause in fields.tables('breaks'):
        break_hours = _hours(pause)
        if hours is not None and break_hours is not None:
            if not _is_within(break_hours, hours):
                pause.refuse('from', f'the break is not within shift {name}', 'change its times')
            breaks.append(break_hours)
    return Shift(name, hours or Hours(0, 0), tuple(breaks), _days(fields))


def _is_within(pause: Hours, hours: Hours) -> bool:
    after = (pause.begin_min - hours.begin_min) % (24 * 60)
    return after + pause.minutes <= hours.minutes


def _hours(fields: Fields) -> Hours | None:
    begin, end = _minutes(fields, 'from'), _minutes(fields, 'to')
    return None if begin is None or end is None else Hours(begin % (24 * 60), end % (24 * 60))


def _minutes(fields: Fields, key: str) -> int | None:
    text = fields.text(key)
    if text is None:
        return None
    if re.fullmatch(CLOCK_FORM, text) is None:
        what = f'`{key}` must be a time of the clock, not {quoted(text)}'
        fields.refuse(key, what, 'write for instance 06:00; hours have two digits')
        return None
    hour, _, minute = text.partition(':')
    return int(hour) * 60 + int(minute)


def _days(fields: Fields) -> tuple[int, ...]:
    days = []
    for node in fields.names('days'):
        if node.text in DAYS:
            days.append(DAYS.index(node.text))
        else:
            hint = did_you_mean(node.text, DAYS, f'write some of {listing(DAYS, longest=7)}')
            fields.report.add(node.place, f'no day is named {quoted(node.text)}', hint)
    return tuple(sorted(set(days))) or EVERY_DAY


def _targets(fields: Fields) -> dict[str, Fraction]:
    target = fields.table('target')
    if target is None:
        return {}
    wanted = {key.name: target.share(key.name) for key in TARGET.keys}
    return {name: Fraction(str(value)) for name, value in wanted.items() if value is not None}


def _zone(fields: Fields) -> str:
    name = fields.text('zone') or ''
    if name:
        try:
            ZoneInfo(name)
        except (LookupError, OSError, ValueError):
            what = f'this computer knows no time zone {quoted(name)}'
            hint = 'write for instance `zone: Europe/Berlin`; the package tzdata has them all'
            fields.refuse('zone', what, hint)
    return name


# Reading a file of the reasons of a plant for stops.

MOST_LETTERS = 80
"""Longest words of a reason: they stand on a button, and in a line of a report."""


def read_reasons(path: Path) -> Mapping[str, PlantReason]:
    """Read a file of reasons; the order of the file is kept.

    :raises Refused: with every mistake in it
    """
    return parse_reasons(read_text(path), str(path))


def parse_reasons(text: str, file: str) -> Mapping[str, PlantReason]:
    """Read the text of a file of reasons; its name stands in the findings.

    :raises Refused: with every mistake in it
    """
    report = Report(file)
    fields = file_fields(text, REASONS, report)
    node = fields.mapping('reasons')
    reasons = {}
    for entry in (*node.entries, *node.repeated) if node else ():
        code = entry.key.text
        check_id(code, 'code of a reason', entry.key.place, report)
        reason = fields_of(entry.value, REASON, report)
        if reason is not None:
            reasons[code] = PlantReason(code, _words(reason), _group(reason))
    if node is not None and not node.entries:
        fields.refuse('reasons', 'no reason is named', REASONS.by_name['reasons'].hint)
    report.refuse()
    return reasons


def _words(fields: Fields) -> Mapping[str, str]:
    node, hint = fields.mapping('words'), REASON.by_name['words'].hint
    words = {}
    for entry in node.entries if node else ():
        language, value = entry.key.text, entry.value
        if re.fullmatch(LANGUAGE_FORM, language) is None:
            what = f'{quoted(language)} is no code of a language'
            fields.report.add(entry.key.place, what, 'write for instance `en` or `de`')
        elif not isinstance(value, Scalar) or not value.text:
            what = f'the words in `{language}` must be a text, not {found(value)}'
            fields.report.add(value.place, what, hint)
        elif _is_fine(value, fields.report):
            words[language] = value.text
    if node is not None and not node.entries:
        fields.refuse('words', 'the reason has no words', hint)
    return words


def _group(fields: Fields) -> str:
    text = fields.text('group')
    node = fields.value('group') if text else None
    return text if text and isinstance(node, Scalar) and _is_fine(node, fields.report) else ''


def _is_fine(node: Scalar, report: Report) -> bool:
    """Tell whether a text fits a line; report it otherwise."""
    if len(node.text) > MOST_LETTERS:
        what = f'the text {quoted(node.text[:20])} and so on has {len(node.text)} characters'
        report.add(node.place, what, f'use at most {MOST_LETTERS}')
    elif not node.text.isprintable():
        what = f'the text {quoted(node.text)} has characters that cannot be seen'
        report.add(node.place, what, 'write it in one line, without control characters')
    else:
        return True
    return False
