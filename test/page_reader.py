"""Somebody who follows a page: types what stands behind `$`, and expects what the page shows.

What is typed stands in `console` blocks, and a file to save in a block below "Save this as". `…`
in what is shown stands for anything. A program that serves stays, in its own terminal, once it
has said the line shown; `^C` before it means the terminal where one like it runs. What only looks
is typed again until it shows what the page does.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from patience import PATIENCE_S
from program_process import ProgramProcess, program_in

from bt_orchestrator.cli.verbs import PROGRAM

STAYING = ('run', 'sim-cell', 'page')
LOOKING = ('status',)
INTERRUPT = '^C\n'
ANYTHING = '…'

_LOOK_S = 0.2


class Typed(NamedTuple):
    """A command of a page, and what is shown below it."""

    place: str
    command: str
    shown: str
    is_after_interrupt: bool

    @property
    def verb(self) -> str:
        """The program's verb; empty for another command."""
        program, *words = shlex.split(self.command)
        return words[0] if program == PROGRAM and words else ''

    def shows(self, printed: str) -> bool:
        """Tell whether this was to be expected."""
        parts = (re.escape(part) for part in self.shown.strip().split(ANYTHING))
        return re.fullmatch('.*'.join(parts), printed.strip(), re.DOTALL) is not None


class Saved(NamedTuple):
    """A file that a page shows, to be saved under a name."""

    place: str
    name: str
    text: str

    @property
    def verb(self) -> str:
        """No verb is typed."""
        return ''


_BLOCK = re.compile(
    r'^(?:Save this as `(?P<name>[^`]+)`:\n\n)?```(?P<kind>\w*)\n(?P<text>.*?)^```$',
    re.MULTILINE | re.DOTALL,
)


def typed(page: Path) -> Iterator[Typed | Saved]:
    """Yield the commands of a page, and the files that it has saved, in order."""
    text = page.read_text(encoding='utf-8')
    for block in _BLOCK.finditer(text):
        place = f'{page.name}:{text.count(chr(10), 0, block.start("text")) + 1}'
        if block['name']:
            yield Saved(place, block['name'], block['text'])
        if block['kind'] != 'console':
            continue
        before, *parts = re.split(r'^\$ ', block['text'], flags=re.MULTILINE)
        assert before in ('', INTERRUPT), f'{place}: what is not typed comes first'
        for number, part in enumerate(parts):
            command, _, shown = part.partition('\n')
            is_after_interrupt = before == INTERRUPT and number == 0
            yield Typed(f'{place} {command}', command, shown, is_after_interrupt)


class PageReader:
    """Follows a page in an empty folder. Ends in `close`, whatever happened.

    :ivar here: where it is
    """

    def __init__(self, folder: Path) -> None:
        self._desk = folder / 'desk'
        self._desk.mkdir()
        self.here = self._desk
        self._prints = folder / 'prints'
        self._prints.mkdir()
        path = f'{program_in(folder / "bin")}:{os.environ["PATH"]}'
        self._environment = {**os.environ, 'PATH': path}
        self._terminals: list[tuple[str, ProgramProcess]] = []

    def follow(self, typed: Typed | Saved) -> None:
        """Do what the page says next, and fail where it shows something else."""
        if isinstance(typed, Saved):
            file = self.here / typed.name
            assert file.parent.is_dir(), typed.place
            file.write_text(typed.text)
            return
        words = shlex.split(typed.command)
        if words[0] == 'cd':
            self.here /= words[1]
            assert self.here.is_dir(), typed.place
        elif typed.verb in STAYING:
            self._start(typed, words[1:])
        elif typed.verb in LOOKING:
            self._look(typed)
        else:
            printed = self._type(typed)
            assert typed.shows(printed), f'{typed.place}\n{printed}'

    def leave(self) -> None:
        """Press Ctrl-C in every terminal, the last one first, and expect a clean end."""
        while self._terminals:
            self._interrupt(len(self._terminals) - 1)

    def close(self) -> None:
        """Leave nothing behind."""
        for _, process in self._terminals:
            process.kill()

    def _start(self, typed: Typed, words: list[str]) -> None:
        if typed.is_after_interrupt:
            verbs = [verb for verb, _ in self._terminals]
            assert typed.verb in verbs, f'{typed.place}: nothing like it runs'
            self._interrupt(len(verbs) - 1 - verbs[::-1].index(typed.verb))
        name = f'{typed.verb}_{len([*self._prints.iterdir()])}'
        process = ProgramProcess(words, self._prints, name, cwd=self.here)
        self._terminals.append((typed.verb, process))
        for line in typed.shown.splitlines():
            assert process.wait_ready(line) == line, typed.place

    def _interrupt(self, terminal: int) -> None:
        _, process = self._terminals.pop(terminal)
        assert process.stop() == 0, process.errors
        process.assert_clean()

    def _look(self, typed: Typed) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not typed.shows(printed := self._type(typed)):
            assert time.monotonic() < deadline, f'{typed.place}\n{printed}'
            time.sleep(_LOOK_S)

    def _type(self, typed: Typed) -> str:
        done = subprocess.run(
            ['sh', '-c', typed.command],
            cwd=self.here,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=2 * PATIENCE_S,
            check=False,
        )
        # What is refused is shown; nothing shown means that all went well.
        assert done.returncode == 0 or typed.shown, f'{typed.place}\n{done.stdout}'
        return done.stdout
