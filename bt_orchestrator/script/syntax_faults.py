"""Saying what is wrong with a text that is not YAML."""

from __future__ import annotations

import re

import yaml

from bt_orchestrator.script.report import START, Place, Report

_CONTROL = re.compile('[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')

_SYNTAX_HINTS = (
    ("'\\t'", 'indent with spaces: YAML allows no tabs there'),
    ('mapping values', 'check the indentation; text that contains `: ` needs quotes'),
    ('end of stream', 'a quote or bracket is opened and never closed'),
    ('<stream end>', 'a quote or bracket is opened and never closed'),
    ("expected ',' or", 'a bracket is not closed, or a comma is missing'),
    ("could not find expected ':'", 'a key needs a colon and a space after it'),
    ('that cannot start any token', 'put the text in quotes'),
    ('expected <block end>', 'lines of one list or mapping must begin in the same column'),
)


def report_syntax(fault: yaml.YAMLError, text: str, report: Report) -> None:
    """Report what the parser stumbled over in a text, with a hint at the usual cause."""
    mark = getattr(fault, 'problem_mark', None) or getattr(fault, 'context_mark', None)
    place = Place(mark.line + 1, mark.column + 1) if mark else START
    problem = ' '.join(str(getattr(fault, 'problem', None) or fault).split())
    hints = (hint for fragment, hint in _SYNTAX_HINTS if fragment in problem)
    hint = next(hints, 'check brackets, quotes and indentation up to here')
    if mark and text[: mark.index].endswith('$') and text.startswith('{', mark.index):
        hint = 'put a reference in quotes: "${...}"'
    report.add(place, f'this is not YAML: {problem}', hint)


def is_printable(text: str, report: Report) -> bool:
    """Tell whether YAML allows every character of a text; report the first that it forbids."""
    control = _CONTROL.search(text)
    if control is None:
        return True
    before = text[: control.start()]
    line = before.count('\n') + 1
    column = control.start() - (before.rfind('\n') + 1) + 1
    what = f'the character U+{ord(control.group()):04X} is not allowed in a text file'
    report.add(Place(line, column), what, 'remove it, or save the file as plain text')
    return False
