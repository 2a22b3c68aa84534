"""The verb `watch`: on a real pseudo-terminal, as plain lines, and for machines."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from cell_processes import CellProcesses, StartCell
from program_process import DEMO_PACKED, ProgramProcess
from pseudo_terminal import PseudoTerminal

from bt_orchestrator.view.screen.blocks import NARROW

OpenTerminal = Callable[..., PseudoTerminal]


@pytest.fixture
def open_terminal() -> Iterator[OpenTerminal]:
    """Give a function that starts a verb on a terminal."""
    opened: list[PseudoTerminal] = []

    def start(*words: str, **options: Any) -> PseudoTerminal:
        opened.append(PseudoTerminal(words, **options))
        return opened[-1]

    yield start
    for terminal in opened:
        terminal.close()


def start_watching(cell: CellProcesses, *words: str) -> ProgramProcess:
    """Start `watch` with its output in a file."""
    return ProgramProcess(['watch', *words], cell.folder, 'watch')


def wait_for(cell: CellProcesses, watching: ProgramProcess, words: str) -> None:
    cell.watch.ros.spin_until(lambda: words in watching.output, f'{words} in {watching.output}')


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_held_cell_is_watched(start_cell: StartCell, open_terminal: OpenTerminal) -> None:
    """It is Held by its worker at the first item of each of two orders."""
    cell = start_cell(fail=['worker.TASK_A#1=abort', 'worker.TASK_A#5=abort'])
    cell.connect()
    cell.run_small(quantity=3)
    cell.watch.until_held()
    _the_terminal_is_pulled_to_other_sizes(open_terminal)
    _without_colour_and_without_a_screen(open_terminal)
    _the_tree_and_the_blackboard_on_a_terminal(open_terminal)
    _a_held_cell_on_a_terminal(cell, open_terminal)
    cell.watch.until_ended('WO-1')
    cell.run_small(quantity=3, order='WO-2')
    cell.watch.until_held()
    _plain_lines_and_json(cell)
    cell.stop()


def leave(terminal: PseudoTerminal) -> None:
    """End it as a person does."""
    terminal.send(signal.SIGINT)
    assert terminal.wait() == 0


def _the_terminal_is_pulled_to_other_sizes(open_terminal: OpenTerminal) -> None:
    terminal = open_terminal('watch', columns=120, lines=30)
    terminal.until_shows('or mark_done, skip, reject, abort_job in place of retry')
    for columns, lines in ((60, 12), (40, 10), (100, 40)):
        terminal.resize(columns, lines)
        terminal.until(_is_one_picture(columns), f'a picture of {columns} columns')
    terminal.until(lambda text: re.search(r'^holds ─{94}$', text, re.MULTILINE), 'a wide rule')
    terminal.send(signal.SIGTERM)
    assert terminal.wait() == 0
    terminal.assert_left_clean()


def _is_one_picture(columns: int) -> Callable[[str], bool]:
    """Return what is so of a picture of a width: the clock ends the first line, where it fits."""

    def is_so(text: str) -> bool:
        first = text.partition('\n')[0]
        fits = len(first) == columns if columns >= NARROW else first == 'small_cell  ■ Held'
        return fits and text.count('hold 1: section') == 1

    return is_so


def _without_colour_and_without_a_screen(open_terminal: OpenTerminal) -> None:
    colourless = open_terminal('watch', environment={'NO_COLOR': '1'})
    dumb = open_terminal('watch', environment={'TERM': 'dumb'})
    colourless.until_shows('■ hold 1: section 2')
    assert not re.search(rb'\x1b\[[\d;]*3[0-7]', colourless.raw)
    dumb.until_shows('hold 1: section 2, work (TASK_A) of WO-1/1 at')
    assert b'\x1b[?1049h' not in dumb.raw
    for terminal in (colourless, dumb):
        leave(terminal)


def _the_tree_and_the_blackboard_on_a_terminal(open_terminal: OpenTerminal) -> None:
    terminal = open_terminal('watch', '--tree', '--blackboard', columns=100, lines=60)
    terminal.until_shows('▶ small_cell  running')
    terminal.until_shows('/small_cell/slots/2')
    assert re.search(r'▶ work \(TASK_A\)  running  waiting for an answer to hold 1', terminal.text)
    assert re.search(r'/small_cell/slots/2 +WO-1/1$', terminal.text, re.MULTILINE)
    leave(terminal)
    terminal.assert_left_clean()


def _a_held_cell_on_a_terminal(cell: CellProcesses, open_terminal: OpenTerminal) -> None:
    (hold,) = cell.watch.status.holds
    terminal = open_terminal('watch')
    terminal.until_shows(f'bt-orchestrator answer {hold.id} retry --reason "WHY"')
    assert terminal.lines[0].startswith('small_cell  ■ Held')
    assert f'■ hold {hold.id}: section 2, work (TASK_A) of WO-1/1 at' in terminal.text
    assert '│ WO-1/1 │' in terminal.lines[1]

    assert cell.watch.answer(hold.id, 'retry').accepted
    terminal.until(lambda text: 'hold 1' not in text, 'the answered hold to go')
    terminal.until_shows('3 of 3 packed')
    leave(terminal)
    terminal.assert_left_clean()


def _plain_lines_and_json(cell: CellProcesses) -> None:
    plain = start_watching(cell)
    machine = ProgramProcess(['watch', '--json', '--tree'], cell.folder, 'machine')
    try:
        wait_for(cell, plain, 'cell small_cell: Held for ')
        wait_for(cell, machine, '"kind": "tree"')
        assert cell.watch.answer('2', 'retry').accepted
        wait_for(cell, plain, 'WO-2 completed\n')
        cell.watch.ros.spin_until(
            lambda: any(packed(snapshot) == 3 for snapshot in statuses(machine)), 'the last item'
        )
        assert (plain.stop(), machine.stop(signal.SIGTERM)) == (0, 0)
        plain.assert_clean()
        machine.assert_clean()
    finally:
        plain.kill()
        machine.kill()
    assert '\x1b' not in plain.output
    assert 'bt-orchestrator answer 2 retry --reason "WHY"\n' in plain.output
    assert re.search(r'^ +\d+\.\d\d s  section 2   WO-2/3 packed$', plain.output, re.MULTILINE)
    snapshots = statuses(machine)
    assert len(snapshots[0]['holds']) == 1
    assert packed(snapshots[-1]) == 3
    sequence = [status['seq'] for status in snapshots]
    assert sequence == sorted(sequence)
    trees = of_kind(machine, 'tree')
    assert trees[0]['name'] == 'small_cell'
    assert trees[0] != trees[-1]


def of_kind(machine: ProgramProcess, kind: str) -> list[Any]:
    """Return what the records of a kind hold, of all whole lines."""
    whole = machine.output.rpartition('\n')[0]
    records = [json.loads(line) for line in whole.splitlines()]
    return [record[kind] for record in records if record['kind'] == kind]


def statuses(machine: ProgramProcess) -> list[Any]:
    return of_kind(machine, 'status')


def packed(status: Any) -> int:
    """Return how many items of WO-2 are packed, by a status."""
    return next((int(job['packed']) for job in status['jobs'] if job['id'] == 'WO-2'), 0)


def test_a_node_goes_away_and_comes_back(
    small_cell: CellProcesses, open_terminal: OpenTerminal
) -> None:
    terminal = open_terminal('watch', '--tree')
    plain = start_watching(small_cell)
    try:
        terminal.until_shows('▶ small_cell  running')
        wait_for(small_cell, plain, 'cell small_cell: ')
        assert small_cell.node.stop() == 0
        terminal.until_shows('no news from /bt_orchestrator for ')
        wait_for(small_cell, plain, 'no news from /bt_orchestrator for ')

        small_cell.start_node()
        small_cell.node.wait_ready()
        terminal.until(lambda text: 'no news' not in text, 'news')
        wait_for(small_cell, plain, 'no news')
        small_cell.watch.ros.spin_until(
            lambda: plain.output.count('cell small_cell: ') == 2, 'the status again'
        )
        small_cell.watch.wait_servers()
        small_cell.run_small(task='TASK_B')
        terminal.until_shows('work (TASK_B)  running  running at worker/task')
        assert plain.stop() == 0
        plain.assert_clean()
    finally:
        plain.kill()


def test_the_demo_on_a_terminal(open_terminal: OpenTerminal) -> None:
    terminal = open_terminal('demo', '--speed', '5', columns=100, lines=50)
    # Any one: a task of a fifth of a second may be over before the next picture.
    terminal.until(lambda text: re.search(r'^  \d .*▶ [\w.]+ [A-Z]', text, re.MULTILINE), 'a task')
    assert terminal.lines[0].startswith('reference_cell  ▶ Execute')
    assert terminal.wait() == 0
    assert re.search(DEMO_PACKED, terminal.text)
    terminal.assert_left_clean()
