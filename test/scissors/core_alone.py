"""Uses the core without one of its extensions, and exits with 1 if that does not work.

    python core_alone.py EXTENSION FOLDER [TEST ...]

Each verb is a fork of this process, in which the extension cannot be imported. TEST: unit tests
of the core, which run at the end.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from bt_orchestrator.base.extending import EXTENSIONS, Extension
from bt_orchestrator.cli.main import main

ROOT = Path(__file__).parents[2]
PATIENCE_S = 60.0

CELL = """\
cell: small_cell
conveyor: {sections: 1, action: /belt, type: bt_orchestrator_interfaces/action/Conveyor,
           task: MOVE_ONE_INDEX}
components:
  robot: {section: 1, action: /robot, type: bt_orchestrator_interfaces/action/Component,
          durations: {TASK_A: 0.1, TASK_B: 0.1}}
"""
SCRIPT = """\
script: small
sections:
  1:
    - {id: place, task: TASK_A, action: /robot, qty_change: 1}
    - {id: pack, task: TASK_B, action: /robot, qty_change: -1}
"""
ORDER = 'order: WO-1\nscript: small\nquantity: 2\n'
BY_RECIPE = 'order: WO-2\nrecipe: anything\nquantity: 1\n'


class Verb:
    """A command line in a fork of this process; what it prints goes to a file."""

    def __init__(self, *words: str) -> None:
        self.words = words
        self._file = Path(f'{words[0]}-{time.monotonic_ns()}.out')
        sys.stdout.flush()
        self._pid = os.fork()
        if self._pid == 0:
            self._be_it()

    def _be_it(self) -> None:
        file = os.open(self._file, os.O_CREAT | os.O_WRONLY)
        os.dup2(file, 1)
        os.dup2(file, 2)
        status = 70
        try:
            status = main(self.words)
        except SystemExit as end:
            status = int(end.code or 0)
        finally:
            sys.stdout.flush()
            os._exit(status)

    @property
    def output(self) -> str:
        return self._file.read_text() if self._file.exists() else ''

    def until(self, words: str) -> None:
        """Wait until it prints something."""
        deadline = time.monotonic() + PATIENCE_S
        while words not in self.output:
            assert time.monotonic() < deadline, f'{self.words}: no {words!r} in {self.output}'
            assert os.waitpid(self._pid, os.WNOHANG) == (0, 0), f'{self.words}: {self.output}'
            time.sleep(0.02)

    def end(self, expected: int = 0) -> str:
        """Return all that it printed when it has ended."""
        _, status = os.waitpid(self._pid, 0)
        code = os.waitstatus_to_exitcode(status)
        assert code == expected, f'{self.words} ended with {code}: {self.output}'
        return self.output

    def interrupt(self) -> str:
        """End it as Ctrl-C does."""
        os.kill(self._pid, signal.SIGINT)
        return self.end()


def written() -> None:
    """Write the files of a small cell."""
    Path('trees').mkdir()
    files = {'cell.yaml': CELL, 'trees/small.yaml': SCRIPT, 'order.yaml': ORDER}
    for name, text in {**files, 'by_recipe.yaml': BY_RECIPE}.items():
        Path(name).write_text(text)


def at_the_desk(extension: Extension) -> None:
    """What needs no node, and the answers of the verbs of the extension."""
    cell = ('--cell', 'cell.yaml')
    asked = [
        (Verb('--help'), 0, 'look back'),
        (Verb('check', 'small', 'order.yaml', *cell), 0, 'fits cell small_cell'),
        (Verb('render', 'small', *cell, '-o', 'line.svg'), 0, ''),
        (Verb('simulate', 'order.yaml', *cell), 0, 'WO-1'),
    ]
    if extension.verb:
        recipe = ['recipe', *cell] if extension.name == 'recipes' else []
        asked.append((Verb(extension.verb, *recipe), 2, extension.missing))
    if extension.name == 'recipes':
        asked.append((Verb('check', 'by_recipe.yaml', *cell), 1, extension.missing))
        asked.append((Verb('new-cell', 'mine', '--sections', '1', '--recipe'), 2, 'pip install'))
    for verb, status, words in asked:
        assert words in verb.end(status), f'{verb.words}: no {words!r} in {verb.output}'


def at_a_node(extension: Extension) -> None:
    """An order of a node with a journal, while somebody watches."""
    servers = Verb('sim-cell', '--cell', 'cell.yaml')
    node = Verb('run', '--cell', 'cell.yaml', '--journal', 'journal.db')
    watch = Verb('watch', '--plain', '--timeout', str(PATIENCE_S))
    node.until('tree node ready')
    Verb('submit', 'order.yaml', '--timeout', str(PATIENCE_S)).end()
    watch.until('WO-1 completed')
    if extension.name == 'recipes':
        answer = Verb('submit', 'by_recipe.yaml').end(1)
        assert extension.missing in answer, answer
    for program in (watch, node, servers):
        program.interrupt()
    assert 'WO-1' in Verb('history', '--journal', 'journal.db').end()
    if extension.name == 'postgres':
        address = 'postgresql://nobody@/plant/cell'
        assert extension.missing in Verb('history', '--journal', address).end(2)
    if extension.name == 'parquet':
        words = ('--journal', 'journal.db', '--format', 'parquet', '-o', 'tables')
        assert extension.missing in Verb('events', *words).end(2)


def unit_tests(files: Sequence[str]) -> None:
    """Run unit tests of the core in this process."""
    import pytest

    os.chdir(ROOT)
    assert pytest.main(['-q', '-p', 'no:cacheprovider', *files]) == 0


def use(extension: Extension, tests: Sequence[str]) -> None:
    """Use the core without an extension."""
    assert extension.missing, f'{extension.name} can be imported'
    written()
    steps: Sequence[Callable[[Extension], None]] = (at_the_desk, at_a_node)
    for step in steps:
        step(extension)
    if tests:
        unit_tests(tests)


if __name__ == '__main__':
    name, folder, *given = sys.argv[1:]
    os.chdir(folder)
    use(next(extension for extension in EXTENSIONS if extension.name == name), given)
