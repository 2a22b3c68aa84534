"""The picture of a cell at many sizes, as text."""

from __future__ import annotations

import io
import re
from typing import Any

import pytest
from fakes import statuses
from rich.cells import cell_len
from rich.console import Console

from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import BeltStatus, CellStatus
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.live import Picture
from bt_orchestrator.view.screen.view import cell_view

NODE = '/bt_orchestrator'
SIZES = [(w, h) for w in (20, 40, 60, 80, 120) for h in (6, 10, 24, 50)]


def picture(status: CellStatus, **about: Any) -> Picture:
    return Picture(cell_view(status, Shell(NODE)), NODE, **about)


def drawn(shown: Picture, width: int = 80, height: int = 24) -> list[str]:
    return [line.plain.rstrip() for line in shown.lines(width, height)]


def printed(shown: Picture, encoding: str = 'utf-8', **options: Any) -> str:
    """Return what a terminal gets."""
    raw = io.BytesIO()
    file = io.TextIOWrapper(raw, encoding=encoding)
    console = Console(file=file, force_terminal=True, width=80, height=24, _environ={}, **options)
    console.print(shown)
    file.flush()
    return raw.getvalue().decode(encoding)


def unstyled(text: str) -> str:
    return re.sub(r'\x1b\[[\d;]*m', '', text)


def test_a_cell_at_work() -> None:
    lines = drawn(picture(statuses.status(), age_s=1.0), height=12)
    assert lines[0].startswith('small_cell  ▶ Execute  ')
    assert NODE in lines[0]
    assert lines[1:] == [
        'belt at rest  │ · │ WO-1/1 │ →',
        'WO-1 small Running ▒░░░░░░░░░ 0 of 10 packed',
        '  1        · waiting for the belt to move',
        '  2 WO-1/1 ▶ work TASK_A at /work/task                                     3.5 s',
        'flags  clear: 0 of 1',
    ]


@pytest.mark.parametrize(
    ('width', 'belt'),
    [
        (80, 'belt at rest  │ WO-1/3✗ │ WO-1/2≈ │ (WO-1/1)✗≈ │ →'),
        (40, 'belt at rest  │ 3✗ │ 2≈ │ (1)✗≈ │ →'),
        (28, 'belt at rest  │✗│≈│✗≈│ →'),
    ],
)
def test_bad_items_have_signs_and_words(width: int, belt: str) -> None:
    bad = [
        statuses.section(1, 'WO-1/3', rejected=True, waiting=['w']),
        statuses.section(2, 'WO-1/2', nonconforming=['weigh'], running=[statuses.task('work')]),
        statuses.section(3, 'WO-1/1', rejected=True, nonconforming=['weigh'], empty_position=True),
    ]
    lines = drawn(picture(statuses.status(sections=bad)), width=width)
    assert lines[1] == belt
    if width == 80:
        assert '  1 WO-1/3   · rejected; w' in lines
        assert any('▶ nonconforming (weigh); work TASK_A' in line for line in lines)


def test_bad_items_have_signs_in_ascii() -> None:
    bad = [statuses.section(1, 'WO-1/3', rejected=True, nonconforming=['weigh'])]
    assert '| WO-1/3x~ |' in printed(picture(statuses.status(sections=bad)), 'ascii')


def test_a_hold_shows_what_to_type() -> None:
    lines = drawn(picture(statuses.status(state=PackmlState.HELD, holds=[statuses.hold()])))
    assert lines[0].startswith('small_cell  ■ Held  ')
    at = lines.index(
        '■ hold 1: section 2, work (TASK_A) of WO-1/1 at arm (/arm/task), attempt 1 of 2:'
    )
    assert lines[at + 1] == '      aborted'
    at += 1
    assert lines[at + 1] == '  bt-orchestrator answer 1 retry --reason "WHY"'
    assert lines[at + 2] == '  or skip in place of retry'


def test_stopped_cell_shows_next_command() -> None:
    lines = drawn(picture(statuses.status(state=PackmlState.STOPPED)))
    at = lines.index('bt-orchestrator cell reset --reason "WHY"   gets the cell ready to start')
    assert lines[at - 1].startswith('next ───')


@pytest.mark.parametrize(('width', 'height'), SIZES)
def test_notes_stay_below_all_else(width: int, height: int) -> None:
    lines = picture(nasty(), notes=['first', 'last']).lines(width, height)
    assert len(lines) <= height
    assert [line.plain for line in lines[-2:]] == ['first', 'last']


def test_a_command_is_wrapped_and_never_cut() -> None:
    lines = drawn(picture(statuses.status(holds=[statuses.hold()])), width=40)
    text = ' '.join(' '.join(lines).split())
    assert 'bt-orchestrator answer 1 retry --reason "WHY"' in text


@pytest.mark.parametrize('width', range(32, 81))
def test_a_command_is_not_broken_at_its_hyphens(width: int) -> None:
    note = 'then .venv/jazzy/bin/bt-orchestrator demo --resume'
    lines = picture(statuses.status(holds=[statuses.hold()]), notes=[note]).lines(width, 24)
    assert not [line.plain for line in lines if re.search(r'\w-$', line.plain)]


def test_missing_components_are_named() -> None:
    gone = [statuses.component('worker', available=False)]
    lines = drawn(picture(statuses.status(components=gone)))
    assert '■ worker: no action server at /worker/task' in lines


def test_a_silent_node_is_said_to_be_silent() -> None:
    lines = drawn(picture(statuses.status(), silent_s=12.0))
    assert lines[2].startswith('no news from /bt_orchestrator for 12.0 s')


def test_a_broken_journal_is_told_first() -> None:
    lines = drawn(picture(statuses.status(journal_failure='no space left on /journal')))
    assert lines[2] == 'NOTHING IS DONE ANY MORE: no space left on /journal'


@pytest.mark.parametrize('held', [3, 20])
def test_of_twenty_sections_those_that_matter_stay(held: int) -> None:
    status = statuses.long_line(20, held=held, working=11)
    lines = drawn(picture(status))
    assert len(lines) <= 24
    assert any(re.match(rf' *{held} WO-1/\d+ +■ waiting for an answer', line) for line in lines)
    assert any(re.match(r' *11 WO-1/10 +▶ work TASK_A', line) for line in lines)
    rows = [line for line in lines if re.match(r' *\d+ WO', line)]
    numbers = [int(line.split()[0]) for line in rows]
    assert numbers == sorted(numbers)
    assert f'… {20 - len(rows)} more lines about sections' in lines
    assert '│20│19│' in lines[1], 'numbers of items where their names do not fit'


def nasty() -> CellStatus:
    """Return a status in which everything is long, or wide, or both."""
    name = '日本語の装置' * 8
    return statuses.status(
        cell=name,
        state=PackmlState.UNSUSPENDING,
        sections=[
            statuses.section(1, f'{name}/123', running=[statuses.task(name, attempt=12)]),
            *(statuses.section(n, f'é{"x" * 90}/{n}', waiting=['w' * 300]) for n in range(2, 30)),
        ],
        jobs=[statuses.job(f'{name}{n}', quantity=3, packed=9, missing=9) for n in range(12)],
        holds=[statuses.hold(str(n), task=name, message='m ' * 200) for n in range(5)],
        components=[statuses.component(name, available=False)] * 9,
        belt=BeltStatus(waits=(statuses.wait('b' * 500),)),
    )


@pytest.mark.parametrize(('width', 'height'), SIZES)
def test_nothing_is_wider_or_higher_than_the_terminal(width: int, height: int) -> None:
    leaf = Branch('b' * 200, Outcome.RUNNING, 'w' * 200, is_decorator=False, children=())
    tree = leaf
    for _ in range(30):
        tree = Branch('b', Outcome.RUNNING, '', is_decorator=True, children=(tree, leaf))
    for status in (statuses.status(), nasty(), statuses.long_line(20, 3, 4)):
        for about in ({}, {'tree': tree, 'blackboard': {'k' * 100: 'v' * 100}, 'silent_s': 9.0}):
            lines = picture(status, **about).lines(width, height)
            assert len(lines) <= height
            assert max(cell_len(line.plain) for line in lines) <= width


def test_shortened_item_keeps_its_number() -> None:
    long = statuses.section(1, 'WORK-ORDER-2026-11-21-A/17', waiting=['waiting'])
    lines = drawn(picture(statuses.status(sections=[long])), width=60)
    assert any(re.search(r'1 …\S+/17 · waiting', line) for line in lines)


def test_without_colour_there_are_no_colours() -> None:
    status = statuses.status(state=PackmlState.HELD, holds=[statuses.hold()])
    assert re.search(r'\x1b\[[\d;]*3[0-7]', printed(picture(status))), 'colours, if allowed'
    plain = printed(picture(status), no_color=True)
    assert not re.search(r'\x1b\[[\d;]*3[0-7]', plain)
    assert 'hold 1' in plain


def test_a_terminal_without_unicode_gets_ascii() -> None:
    status = statuses.long_line(20, held=3, working=4)
    text = unstyled(printed(picture(status), encoding='ascii'))
    assert '> work TASK_A' in text
    assert '! waiting for an answer' in text


def test_the_tree_and_the_blackboard() -> None:
    leaf = Branch('pick', Outcome.RUNNING, 'running at /arm', is_decorator=False, children=())
    done = Branch('home', Outcome.SUCCESS, '', is_decorator=False, children=())
    root = Branch('cell', Outcome.RUNNING, '', is_decorator=False, children=(done, leaf))
    lines = drawn(picture(statuses.status(), tree=root, blackboard={'/cell/belt': 'at rest'}))
    assert '  ▶ pick  running  running at /arm' in lines
    assert '  ✓ home  success' in lines
    assert '/cell/belt at rest' in lines
    assert not any('waiting for the belt to move' in line for line in lines)
