"""Write what is made from the code: parts of the pages (keys, events, verbs), and schemas/.

    python docs/generate.py          write them
    python docs/generate.py --check  say which files are not up to date, exit 1

A generated part stands between `<!-- generated: NAME -->` and `<!-- end -->`; what is between them
is replaced, everything else is the author's.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import importlib
import inspect
import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from functools import cache, partial
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.main import PROGRAM, VERBS
from bt_orchestrator.model import events
from bt_orchestrator.model.codec import event_types
from bt_orchestrator.model.fault import FaultKind
from bt_orchestrator.model.isa95 import JobWord
from bt_orchestrator.model.job_control import METHODS, Method
from bt_orchestrator.model.packml import MEANINGS, TRANSITIONS, Cause, Mode
from bt_orchestrator.model.packml import VERBS as CELL_VERBS
from bt_orchestrator.model.stop_reason import WORDS, StopReason
from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.json_schema import SCHEMA_FILES, json_schema
from bt_orchestrator.script.keys import LARGEST_WHOLE, LONGEST_SECONDS, Key, Kind, Table
from bt_orchestrator.script.script_keys import ORDER, SCRIPT

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    'README.md',
    'docs/semantics.md',
    'docs/formats.md',
    'docs/script_reference.md',
    'docs/operating.md',
    'docs/queue.md',
)

_PART = re.compile(r'(<!-- generated: (?P<name>[\w -]+) -->\n).*?(?=<!-- end -->)', re.DOTALL)

FIELDS: Mapping[str, str] = {
    'action': 'ROS 2 action name',
    'answer': 'what was decided',
    'answers': 'what an operator may answer',
    'args': 'goal fields with plain values, references resolved',
    'attempt': 'which attempt, from 1',
    'beat': 'the beat that begins',
    'cell': 'name of the cell',
    'counts': 'the counts of the job, by name (semantics 6.2)',
    'component': 'name of the component in the cell file',
    'definition': 'the whole script, bound to the cell',
    'digest': 'name of the script by what it says: equal scripts have equal digests',
    'flag': 'name of the flag',
    'goal': 'goal UUID',
    'hold': 'id of the hold',
    'item': 'item id, `<job>/<n>`',
    'job': 'job id, the id of its work order',
    'message': 'the words of the server or the gateway, for a person',
    'params': 'all parameters, defaults filled in',
    'previous': 'the state before',
    'quantity': 'number of source cycles',
    'ready': 'whether a goal may be sent',
    'reason': 'why, one word or a sentence',
    'results': 'result fields of the task, `task_result` left out',
    'script': 'name of the script',
    'section': 'section number',
    'state': 'PackML state of the cell',
    'task': 'task id in the script; `index` for the move of the belt',
    'command': 'what was commanded',
    'who': 'who decided',
}
"""What a field means wherever the class says nothing of its own."""

PLACE = ('job', 'section', 'item', 'task')
"""Fields that most events have; explained once, above the tables."""


# --- keys -------------------------------------------------------------------------------------


def keys_of(root: Table) -> Iterator[str]:
    """Yield a table for every kind of mapping that can be met below a root."""
    for table in {table.name: table for table in root.tree()}.values():
        yield f'**{table.name[0].upper()}{table.name[1:]}**'
        yield ''
        yield from keys_in(table)


def keys_in(table: Table) -> Iterator[str]:
    """Yield the keys of one kind of mapping."""
    yield '| key | value | meaning | example | rule |'
    yield '|---|---|---|---|---|'
    for key in table.keys:
        words = [f'`{key.name}`', _value(key), _meaning(key), _code(key.example), _rule(key)]
        yield f'| {" | ".join(words)} |'
    yield ''


def _rule(key: Key) -> str:
    return f'[{key.rule}](semantics.md#{_chapters()[key.rule.partition(".")[0]]})'


@cache
def _chapters() -> Mapping[str, str]:
    """Return what links call the chapters of the rules, by their numbers."""
    text = (ROOT / 'docs' / 'semantics.md').read_text(encoding='utf-8')
    headings = re.findall(r'^## ((\d)\. .*)$', text, re.MULTILINE)
    return {
        number: re.sub(r'[^\w -]', '', heading.lower()).replace(' ', '-')
        for heading, number in headings
    }


def _value(key: Key) -> str:
    if key.choices:
        return ', '.join(f'`{choice}`' for choice in key.choices)
    return key.kind.in_words


def _meaning(key: Key) -> str:
    notes = [key.meaning]
    if key.required:
        notes.append('**required**')
    if key.default is not None:
        notes.append(f'default `{_plain(key.default)}`')
    if key.minimum is not None and key.kind in (Kind.WHOLE, Kind.SECONDS, Kind.TIMEOUT):
        notes.append(_range(key))
    return _cell('; '.join(notes))


def _range(key: Key) -> str:
    low = f'more than {key.minimum:g}' if key.kind is Kind.TIMEOUT else f'{key.minimum:g}'
    if key.maximum in (None, LARGEST_WHOLE, LONGEST_SECONDS):
        return low if key.kind is Kind.TIMEOUT else f'at least {low}'
    return f'{low} to {key.maximum:g}'


def _plain(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


# --- events -----------------------------------------------------------------------------------


def events_in_groups() -> Iterator[str]:
    """Yield a table of every event class, by the part of its name before the dot."""
    groups: dict[str, list[type[events.Event]]] = {}
    for name, kind in event_types().items():
        groups.setdefault(name.partition('.')[0], []).append(kind)
    documented = _attribute_docstrings()
    yield '| where in the line | meaning |'
    yield '|---|---|'
    for name in PLACE:
        yield f'| `{name}` | {_cell(FIELDS[name])} |'
    yield ''
    for group, kinds in groups.items():
        yield f'### {group}'
        yield ''
        yield '| event | meaning | fields |'
        yield '|---|---|---|'
        for kind in kinds:
            fields = '<br>'.join(_event_fields(kind, documented))
            yield f'| `{kind.event}` | {_cell(inspect.cleandoc(kind.__doc__ or ""))} | {fields} |'
        yield ''


def _event_fields(
    kind: type[events.Event], documented: Mapping[tuple[str, str], str]
) -> list[str]:
    place, lines = [], []
    for field in dataclasses.fields(kind):
        if field.name in ('seq', 'time'):
            continue
        said = (documented.get((base.__name__, field.name)) for base in kind.__mro__)
        own = next((text for text in said if text), None)
        absent = '?' if _has_default(field) else ''
        if own is None and field.name in PLACE:
            place.append(f'`{field.name}{absent}`')
        else:
            lines.append(f'`{field.name}{absent}`: {_cell(own or _common(kind, field.name))}')
    return [', '.join(place), *lines] if place else lines


def _common(kind: type[events.Event], field: str) -> str:
    """Return what a field means in any event.

    :raises SystemExit: nobody says it
    """
    if field not in FIELDS:
        what = f'{kind.__name__}.{field} has no meaning; write a docstring below the field'
        raise SystemExit(f'docs/generate.py: {what}, or a line in FIELDS')
    return FIELDS[field]


def _has_default(field: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return field.default is not missing or field.default_factory is not missing


def _attribute_docstrings() -> dict[tuple[str, str], str]:
    """Return the strings that stand below the fields of the event classes."""
    found = {}
    for kind in (kind for kind in vars(events).values() if isinstance(kind, type)):
        node = ast.parse(inspect.getsource(kind)).body[0]
        assert isinstance(node, ast.ClassDef)
        for field, below in zip(node.body, node.body[1:], strict=False):
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                text = _string(below)
                if text is not None:
                    # A record leaves out what the class calls None.
                    found[node.name, field.target.id] = text.replace('None', 'absent')
    return found


def _string(node: ast.stmt) -> str | None:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return inspect.cleandoc(str(node.value.value)).rstrip('.')
    return None


def fault_kinds() -> Iterator[str]:
    """Yield a table of what a simulated controller can do wrong."""
    yield '| kind | what happens |'
    yield '|---|---|'
    for kind, meaning in _member_docstrings(FaultKind).items():
        yield f'| `{kind}` | {_cell(meaning)} |'
    yield ''


# --- jobs -------------------------------------------------------------------------------------


def job_methods() -> Iterator[str]:
    """Yield what every method of a job does."""
    yield '| method (ISA-95) | `queue ...` | does |'
    yield '|---|---|---|'
    for method in METHODS:
        yield f'| {method.name} | `{method.verb}` | {_cell(method.meaning)} |'
    yield ''


def job_states() -> Iterator[str]:
    """Yield which state follows from which method in which state."""
    yield f'| | {" | ".join(word.value for word in JobWord)} |'
    yield '|---|' + '---|' * len(JobWord)
    for method in METHODS[2:]:
        after = (_after(method, before) for before in JobWord)
        yield f'| {method.name} | {" | ".join(after)} |'
    yield ''


def _after(method: Method, before: JobWord) -> str:
    if before not in method.changes:
        return ''
    after = method.changes[before]
    return 'listed no more' if after is None else after.value


# --- verbs ------------------------------------------------------------------------------------


def verbs() -> Iterator[str]:
    """Yield the table of all verbs."""
    yield '| verb | does |'
    yield '|---|---|'
    for name, (_, line) in VERBS.items():
        yield f'| `{name}` | {_cell(line)} |'
    yield ''


def options() -> Iterator[str]:
    """Yield what every verb takes."""
    for name, (module, line) in VERBS.items():
        yield f'### `{PROGRAM} {name}`'
        yield ''
        yield f'{line[0].upper()}{line[1:]}.'
        yield ''
        yield '| argument | meaning |'
        yield '|---|---|'
        for action in _actions(module):
            words = ', '.join(action.option_strings) or _metavar(action)
            value = f' {_metavar(action)}' if action.option_strings and action.nargs != 0 else ''
            needed = ' **(required)**' if action.required and action.option_strings else ''
            text = (action.help or '') % {**vars(action), 'prog': PROGRAM}
            yield f'| `{_cell(words + value)}` | {_cell(text)}{needed} |'
        yield ''


class _Recorder(argparse.ArgumentParser):
    """A parser that can be asked for what was declared."""

    def __init__(self) -> None:
        self.declared: list[argparse.Action] = []
        super().__init__(add_help=False)

    def add_argument(self, *names: Any, **settings: Any) -> argparse.Action:
        action = super().add_argument(*names, **settings)
        self.declared.append(action)
        return action


def _actions(module: str) -> list[argparse.Action]:
    parser = _Recorder()
    importlib.import_module(f'bt_orchestrator.cli.{module}').add_arguments(parser)
    return parser.declared


def _metavar(action: argparse.Action) -> str:
    if action.choices is not None and not isinstance(action.metavar, str):
        return '|'.join(map(str, action.choices))
    name = str(action.metavar or action.dest.upper())
    return f'{name}...' if action.nargs in ('+', '*') else name


# --- rules ------------------------------------------------------------------------------------

_RULE_TEST = re.compile(r'^def test_(\d)_(\d+)_', re.MULTILINE)


def tests_of_rules() -> Iterator[str]:
    """Yield a table of the rules with the files whose tests are named after them."""
    files: dict[tuple[int, int], set[Path]] = {}
    for path in (ROOT / 'test').rglob('test_*.py'):
        for chapter, rule in _RULE_TEST.findall(path.read_text(encoding='utf-8')):
            files.setdefault((int(chapter), int(rule)), set()).add(path)
    yield '| rule | tests named after it |'
    yield '|---|---|'
    for (chapter, rule), paths in sorted(files.items()):
        links = (f'[{p.stem}](../{p.relative_to(ROOT).as_posix()})' for p in sorted(paths))
        yield f'| {chapter}.{rule} | {", ".join(links)} |'
    yield ''


# --- the cell ---------------------------------------------------------------------------------


def states() -> Iterator[str]:
    """Yield what every state means."""
    yield '| state | means | cycles begin | cycles in hand go on |'
    yield '|---|---|---|---|'
    for mode in Mode:
        marks = ['yes' if answer else 'no' for answer in (mode.begins, mode.works)]
        yield f'| {mode.value} | {MEANINGS[mode]} | {" | ".join(marks)} |'
    yield ''


def stop_reasons() -> Iterator[str]:
    """Yield every stop reason in both vocabularies."""
    yield '| reason | means | to the cell | jobs on the line |'
    yield '|---|---|---|---|'
    documented = _member_docstrings(StopReason)
    for reason, words in WORDS.items():
        means = _cell(documented[reason.value])
        job = f'Interrupted / {words.job.value}'
        yield f'| {reason.value} | {means} | {words.cell.value} | {job} |'
    yield ''


def commands_in_states() -> Iterator[str]:
    """Yield the table of transitions: commands, and what the cell does by itself."""
    by_itself = (Cause.SUSPEND, Cause.UNSUSPEND, Cause.DONE)
    named = [f'`{verb}`' for verb in CELL_VERBS.values()]
    yield f'| in | {" | ".join(named)} | by itself |'
    yield '|---' * (len(named) + 2) + '|'
    for mode, row in TRANSITIONS.items():
        commands = [row[cause].value if cause in row else '-' for cause in CELL_VERBS]
        itself = ', '.join(row[cause].value for cause in by_itself if cause in row)
        yield f'| {mode.value} | {" | ".join(commands)} | {itself} |'
    yield ''


def _member_docstrings(kind: type[Enum]) -> dict[str, str]:
    """Return the strings that stand below the members of an enumeration."""
    source = ast.parse(inspect.getsource(kind)).body[0]
    assert isinstance(source, ast.ClassDef)
    return {
        str(member.value.value): _string(below) or ''
        for member, below in zip(source.body, source.body[1:], strict=False)
        if isinstance(member, ast.Assign) and isinstance(member.value, ast.Constant)
    }


# --- pages ------------------------------------------------------------------------------------

PARTS: Mapping[str, Callable[[], Iterator[str]]] = {
    'keys of a cell file': lambda: keys_of(CELL),
    **{f'keys of {table.name}': partial(keys_in, table) for table in SCRIPT.tree()},
    'keys of a work order': lambda: keys_of(ORDER),
    'kinds of faults': fault_kinds,
    'methods of a job': job_methods,
    'states of a job': job_states,
    'events': events_in_groups,
    'tests of the rules': tests_of_rules,
    'verbs': verbs,
    'options of the verbs': options,
    'states of the cell': states,
    'stop reasons': stop_reasons,
    'commands and states': commands_in_states,
}


def generated(text: str) -> str:
    """Return a page with its generated parts made anew."""
    return _PART.sub(lambda part: part[1] + '\n' + '\n'.join(PARTS[part['name']]()) + '\n', text)


def stale_files(root: Path = ROOT) -> dict[str, str]:
    """Return what the files have to say that do not say what the code says."""
    wanted = {page: generated((root / page).read_text(encoding='utf-8')) for page in PAGES}
    for name, table in SCHEMA_FILES.items():
        wanted[f'schemas/{name}'] = json.dumps(json_schema(table), indent=2) + '\n'
    return {name: text for name, text in wanted.items() if _text(root / name) != text}


def _text(path: Path) -> str:
    return path.read_text(encoding='utf-8') if path.exists() else ''


def main(words: Sequence[str]) -> int:
    """Write the files, or check them."""
    stale = stale_files()
    if '--check' in words:
        for name in stale:
            sys.stderr.write(f'{name} is not up to date: run python docs/generate.py\n')
        return 1 if stale else 0
    for name, text in stale.items():
        (ROOT / name).write_text(text, encoding='utf-8')
        sys.stdout.write(f'{name} written\n')
    return 0


def _cell(text: str) -> str:
    """Return a text for one cell of a table."""
    return ' '.join(text.split()).replace('|', r'\|')


def _code(text: str) -> str:
    return f'`` {_cell(text)} ``' if '`' in text else f'`{_cell(text)}`'


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
