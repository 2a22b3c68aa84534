"""Two mistakes in one file are both told, and nothing that only follows from one of them (8.1)."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple, cast

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.mistakes_together import (
    CELL_FRAME,
    ORDER_FRAME,
    RECIPE_FRAME,
    RICH,
    SCRIPT_FRAME,
    Frame,
    Plant,
)
from fakes.profiles import PROFILE
from fakes.recipe_texts import recipe
from fakes.script_texts import LINE, line, mistakes, script

from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.orders.order_file import bind_order, parse_draft

PAIRS = 1_000_000 if PROFILE == 'nightly' else 500
"""Of each kind of file; there are about 22,000 in scripts."""

LOST_ID = 'task_options: empty id'
"""The task may have had any id, so a name that no other task has is perhaps right."""

UNKNOWN_ID = re.compile(r'.*(there is no .*task|names no task|is not an initialization task)')

ORDERED = line(
    'params: {lot: {type: str}, n: {type: int, default: 3}, '
    'x: {type: float, default: 1}, b: {type: bool, default: false}}\n'
)


class Kind(NamedTuple):
    """A kind of file: where mistakes can be in it, and who reads it."""

    frame: Frame
    read: Callable[[str], object]


def read_cell(text: str) -> object:
    return parse_cell(text, 'cell.yaml', FakeActionTypes())


def read_order(text: str) -> object:
    file = parse_draft(text, 'order.yaml')
    return bind_order(file.order, ORDERED, 'J1', file.places)


KINDS = {
    'script': Kind(SCRIPT_FRAME, script),
    'cell': Kind(CELL_FRAME, read_cell),
    'order': Kind(ORDER_FRAME, read_order),
    'recipe': Kind(RECIPE_FRAME, recipe),
}


@cache
def told(kind: str, *plants: Plant) -> frozenset[str]:
    """Return the mistakes that a file with these plants is told, without the hints.

    A hint lists what there is, and that may be another plant's.
    """
    frame, read = KINDS[kind]
    findings = mistakes(lambda: read(frame.planted(*plants)))
    return frozenset(finding.partition('; ')[0] for finding in findings)


def chosen(frame: Frame) -> list[tuple[Plant, Plant]]:
    pairs = list(frame.pairs())
    return random.Random(0).sample(pairs, min(PAIRS, len(pairs)))


@pytest.mark.parametrize('kind', KINDS)
def test_every_place_is_told_of_its_own_mistakes(kind: str) -> None:
    assert told(kind) == frozenset()
    for plant in KINDS[kind].frame.plants():
        assert told(kind, plant), plant


@pytest.mark.parametrize('kind', KINDS)
def test_two_mistakes_are_told_and_nothing_that_follows(kind: str) -> None:
    for first, second in chosen(KINDS[kind].frame):
        both = told(kind, first, second)
        each = told(kind, first) | told(kind, second)
        if LOST_ID in (first.name, second.name):
            each = frozenset(flaw for flaw in each if flaw in both or not UNKNOWN_ID.match(flaw))
        assert both == each, (first.name, second.name)


HOLDERS = {
    'unknown action': '    - {{task: RUN, action: /nowhere{}}}\n',
    'unknown task': '    - {{task: RN, action: /lamp/task{}}}\n',
    'further key': '    - {{task: RUN, action: /lamp/task, colour: red{}}}\n',
    'list in a list': '    - [{{task: RUN, action: /lamp/task{}}}]\n',
    'group of one': '    - {{parallel: [{{task: RUN, action: /lamp/task{}}}]}}\n',
    'group in a group': '    - {{parallel: [{{action: /cart/drive}}, {{parallel: ['
    '{{task: RUN, action: /lamp/task{}}}, {{task: TASK_A, action: /press/task}}]}}]}}\n',
    'misspelt group': '    - {{paralel: [{{task: RUN, action: /lamp/task{}}}, '
    '{{action: /cart/drive}}]}}\n',
}
"""Wrong things around the options of a task."""

SECTIONS = {
    'unknown section': '  9:\n',
    'text for a section': '  two:\n',
    'section given twice': '  1:\n',
    'misspelt release': '  3:\n    release_conveyer: end_of_cycle\n    tasks:\n',
}
"""Wrong things around the options of a task and two tasks that others refer to."""

AROUND_OPTIONS = {
    **{name: f'  3:\n{holder}' for name, holder in HOLDERS.items()},
    **{name: f'{section}{RICH}' for name, section in SECTIONS.items()},
    'task without a list': f'  3: {RICH.strip()[2:]}\n',
    'group in initialization': 'initialization:\n'
    '  - {{parallel: [{{task: RUN, action: /lamp/task{}}}, {{action: /cart/drive}}]}}\n',
}


def whats(text: str) -> list[str]:
    """Return what is told of a script, without places and hints."""
    findings = mistakes(lambda: script(text))
    return sorted(finding.partition(': ')[2].partition('; ')[0] for finding in findings)


def options() -> Iterator[tuple[str, str]]:
    """Yield the wrong options of tasks that initialization has too."""
    for case in table('task_options'):
        text, findings = cast(tuple[str, list[str]], case.values)
        if findings and not re.search('qty_change|when|runs_for|on_failure|once|colour', text):
            yield cast(str, case.id), text


@pytest.mark.parametrize('around', AROUND_OPTIONS.values(), ids=AROUND_OPTIONS)
def test_mistake_around_task_hides_no_inner_mistake(around: str) -> None:
    outside = whats(LINE + around.format(''))
    assert outside
    for name, text in options():
        inside = whats(LINE + '  3:\n' + RICH.format(text))
        findings = [
            finding.replace('an initialization task', 'a task')
            for finding in whats(LINE + around.format(text))
        ]
        assert findings == sorted(outside + inside), name


@pytest.mark.parametrize('section', SECTIONS.values(), ids=SECTIONS)
def test_a_wrong_section_hides_no_unknown_id(section: str) -> None:
    tasks = '    - {id: look, task: RUN, action: /lamp/task}\n'
    flags = 'lateral_dependencies: [{flag: f, upstream: look, downstream: pck}]\n'
    (unknown,) = set(whats(LINE + section + tasks + flags)) - set(whats(LINE + section + tasks))
    assert unknown == 'there is no task `pck`'


@pytest.mark.parametrize(
    'unreadable',
    ['  2: [look]\n', '  2: look\n', '  2: {steps: [{id: look}]}\n', '  2: [{id: [look]}]\n'],
)
def test_unreadable_part_hides_only_its_own_ids(unreadable: str) -> None:
    zones = 'zones: {t: [look, place], u: [nowhere, place]}\n'
    findings = [flaw for flaw in whats(LINE + unreadable + zones) if 'there is no' in flaw]
    assert findings == ['there is no task `nowhere`']


TAIL = """\
initialization: [{id: home, task: HOME, action: /belt/index, once: 3}]
lateral_dependencies: [{flag: a b, upstream: home, downstream: nowhere}]
zones: {t: [nowhere, home]}
"""


@pytest.mark.parametrize(('text', 'expected'), table('balance'))
def test_quantities_and_relations_are_told_together(text: str, expected: list[str]) -> None:
    tail = set(whats(LINE + TAIL))
    assert set(whats(f'{text}\n{TAIL}')) == tail | set(whats(text))


def test_quantities_are_told_beside_what_cannot_be_read() -> None:
    findings = whats(
        LINE + '  2: [{id: also, task: RUN, action: /camera/task, qty_change: 1,\n'
        '    when: "${order.id}"}, {task: RUN, action: /camera/task, qty_change: 2}, RUN]\n'
    )
    assert [finding for finding in findings if 'item' in finding] == [
        'a task that places the item cannot have `when`',
        'items are placed twice, by `place` and by `also`',
    ]


def test_every_broken_reference_of_a_text_is_told() -> None:
    findings = whats(
        LINE + '  3: [{task: TASK_A, action: /press/task, '
        'args: {special_argument_1: "${param.x} ${results.no.x} ${order.x}"}}]\n'
    )
    assert findings == [
        '`${order.x}` does not exist',
        '`${param.x}` has an unknown source',
        '`${results.no.x}` names no task of the script',
    ]


def test_references_are_checked_where_the_action_is_unknown() -> None:
    findings = whats(LINE + '  3: [{action: /nowhere, args: {a: [{b: "${results.no.x}"}]}}]\n')
    assert findings[0] == '`${results.no.x}` names no task of the script'


def test_both_sides_of_a_comparison_are_told() -> None:
    findings = whats(
        LINE + '  3: [{action: /cart/drive, when: {value: "${params.no}", equals: [3]}}]\n'
    )
    assert findings == [
        '`equals` must be a plain value, not a list',
        'the script has no parameter `no`',
    ]


def test_what_is_given_again_is_read_too() -> None:
    findings = whats(
        LINE + 'zones: {t: [place, pack]}\n'
        'zones: {u: [place, nowhere]}\n'
        'params: {a: {type: str}, a: {type: text}, a b: {type: int}}\n'
    )
    assert findings == [
        '`a b` cannot be a parameter name: only letters, digits, `_` and `-` are allowed',
        '`type` cannot be `text`',
        'the key `a` is given twice',
        'the key `zones` is given twice',
        'there is no task `nowhere`',
    ]
