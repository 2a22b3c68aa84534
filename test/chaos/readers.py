"""Everybody who reads a cell while it is shot at; none may disturb, and none may be misled."""

from __future__ import annotations

import csv
import io
import itertools
import json
import re
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from chaos.copying import COPIES
from chaos.witnesses import misled, vanished
from program_process import ProgramProcess

_PAUSE_S = 1.0
"""Between two that only look once."""

_PATIENCE_S = '20'
"""How long those wait for the node who look all the time."""

_UNREACHABLE = ('did not come within', 'cannot tell its events')
"""What a client says whose node is dead, or cannot reach its database."""

_STARTING = ('', 'KeyboardInterrupt')
"""The last line of one that is stopped while Python starts."""

COPYING = Path(__file__).with_name('copying.py')


class Follower:
    """A program that prints what happens, as long as it lives; another one goes on after it.

    :ivar printed: every line, of all programs
    :ivar complaints: how programs ended that should not have
    """

    def __init__(self, name: str, folder: Path) -> None:
        self.name = name
        self._folder = folder
        self._numbers = itertools.count(1)
        self._process: ProgramProcess | None = None
        self.printed: list[str] = []
        self.complaints: list[str] = []

    def look(self, words: Callable[[], Sequence[str]]) -> None:
        """Start a program unless one runs."""
        if self._process is not None and not self._process.is_running:
            self._take_over()
        if self._process is None:
            name = f'{self.name}_{next(self._numbers)}'.replace(' ', '_')
            self._process = ProgramProcess(words(), self._folder, name)

    def stop(self) -> None:
        """End it, and take in what it has printed."""
        if self._process is not None:
            self._process.stop()
            self._take_over(stopped=True)

    def kill(self) -> None:
        """Leave nothing behind."""
        if self._process is not None:
            self._process.kill()

    def _take_over(self, *, stopped: bool = False) -> None:
        assert self._process is not None
        status, errors = self._process.wait(), self._process.errors.strip()
        self.printed += self._process.output.splitlines()
        self._process = None
        # One that is stopped while Python starts has nothing better to say.
        is_well = status == 0 or (stopped and errors.rpartition('\n')[2] in _STARTING)
        if not is_well and not _is_cut_off(errors):
            self.complaints.append(f'{self.name} ended with {status}: {errors[-300:]}')


class Readers:
    """States: reading (`look` again and again), over (after `stop`)."""

    def __init__(self, folder: Path, journal: Path | None) -> None:
        """Prepare; the first `look` starts everything.

        :param folder: for what they say
        :param journal: its file; None: it is in a database, and only the node is asked
        """
        folder.mkdir()
        self._folder = folder
        self._journal = journal
        self._of_file = Follower('events --journal --follow', folder)
        self._of_node = Follower('events --since-seq', folder)
        self._of_status = Follower('watch --json', folder)
        of_node = {words: _ONCE[words] for words in _ONCE if journal or 'FILE' not in words}
        self._once = itertools.cycle(of_node.items())
        self._visitor: tuple[str, ProgramProcess] | None = None
        self._next_s = 0.0
        self._lives = 0
        """Of nodes."""
        self._copying: ProgramProcess | None = None
        self.looks = 0
        """How often one has looked once."""
        self.complaints: list[str] = []

    def look(self) -> None:
        """Start whoever is to read now."""
        file = self._journal
        if file is not None and not file.exists():
            return
        if file is not None and self._lives % 2:
            self._of_file.look(
                lambda: self._words(self._of_file, '--journal', str(file), '--follow')
            )
        self._of_node.look(lambda: self._words(self._of_node, '--timeout', _PATIENCE_S))
        self._of_status.look(lambda: ['watch', '--json', '--timeout', _PATIENCE_S])
        self._look_once()

    def copy(self, pid: int) -> None:
        """Copy the journal for as long as a process lives that writes it.

        In every other such life nobody has the file open all the time: who has keeps those who
        copy it from tidying up beside it.
        """
        if self._journal is None:
            return
        self._lives += 1
        if not self._lives % 2:
            self._of_file.stop()
        self._end_copying()
        words = [str(self._journal), str(pid), str(self._folder)]
        self._copying = ProgramProcess(words, self._folder, 'copying', [str(COPYING)])

    def stop(self) -> None:
        """End all of them, once the last node has ended."""
        for follower in self._followers:
            follower.stop()
            self.complaints += follower.complaints
        self._end_copying()
        if self._visitor is not None:
            self._judge_visitor(*self._visitor)
            self._visitor = None

    def kill(self) -> None:
        """Leave nothing behind, whatever happened."""
        for follower in self._followers:
            follower.kill()
        for process in (self._copying, self._visitor and self._visitor[1]):
            if process is not None:
                process.kill()

    # --- what they say ------------------------------------------------------------------------

    @property
    def copies(self) -> list[dict[str, Any]]:
        """What was in each copy, and in each reading by anybody."""
        file = self._folder / COPIES
        return _records(file.read_text().splitlines()) if file.exists() else []

    @property
    def seqs_of_status(self) -> list[int]:
        """The last event that each status contains which was printed."""
        return [r['status']['seq'] for r in _records(self._of_status.printed) if 'status' in r]

    def misled(self, journal: Sequence[dict[str, Any]]) -> Iterator[str]:
        """Say what followers were told that is not so, or twice, or not at all."""
        for follower in (self._of_file, self._of_node):
            records = _records(follower.printed)
            yield from misled(records, follower.name)
            yield from vanished(journal, records, follower.name)

    # --- one after the other ------------------------------------------------------------------

    @property
    def _followers(self) -> tuple[Follower, ...]:
        return self._of_file, self._of_node, self._of_status

    def _words(self, follower: Follower, *options: str) -> list[str]:
        """Return a command line with which one goes on where the one before ended."""
        records = _records(follower.printed)
        return ['events', '--since-seq', str(records[-1]['seq'] if records else 0), *options]

    def _look_once(self) -> None:
        if self._visitor is not None:
            if self._visitor[1].is_running:
                return
            self._judge_visitor(*self._visitor)
            self._visitor, self._next_s = None, time.monotonic() + _PAUSE_S
        elif time.monotonic() >= self._next_s:
            words, _ = next(self._once)
            given = [str(self._journal) if word == 'FILE' else word for word in words.split()]
            self._visitor = words, ProgramProcess(given, self._folder, 'visitor')

    def _judge_visitor(self, words: str, process: ProgramProcess) -> None:
        self.looks += 1
        status = process.wait()
        if status and _is_cut_off(process.errors) and 'FILE' not in words:
            return
        wrong = process.errors
        if not status and not wrong:
            wrong = _wrong(_ONCE[words], process.output)
        if wrong or status:
            self.complaints.append(f'{words} ended with {status}: {wrong.strip()[-300:]}')

    def _end_copying(self) -> None:
        if self._copying is None:
            return
        if self._copying.wait():
            self.complaints.append(f'copying: {self._copying.errors.strip()[-300:]}')
        self._copying = None


def _is_cut_off(errors: str) -> bool:
    return any(words in errors for words in _UNREACHABLE)


def _records(lines: Sequence[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in lines]


def _wrong(judge: Callable[[str], str], text: str) -> str:
    """Say what is wrong with an output; empty: nothing."""
    try:
        return judge(text)
    except (KeyError, ValueError, ET.ParseError) as error:
        return f'{error!r} in {text[:100]!r}'


def _wrong_numbers(seqs: Sequence[int]) -> str:
    """Say whether events are not numbered from 1 on, without gaps."""
    return '' if seqs == list(range(1, len(seqs) + 1)) else f'events {seqs[:20]}...'


def _wrong_json(text: str) -> str:
    _records(text.splitlines())
    return ''


def _wrong_xes(text: str) -> str:
    return '' if ET.fromstring(text).tag.endswith('log') else 'no log'


def _wrong_csv(text: str) -> str:
    return _wrong_numbers([int(row['seq']) for row in csv.DictReader(io.StringIO(text))])


_ONCE: dict[str, Callable[[str], str]] = {
    'history --journal FILE': lambda text: '' if text.startswith('job') else text,
    'events --journal FILE --format jsonl': lambda text: _wrong_numbers(
        [record['seq'] for record in _records(text.splitlines())]
    ),
    'status': lambda text: '' if text else 'nothing',
    'events --journal FILE --format csv': _wrong_csv,
    'history --journal FILE --items --json': _wrong_json,
    'events --journal FILE --format text': lambda text: _wrong_numbers(
        [int(seq) for seq in re.findall(r'^\S+ \S+  #(\d+) ', text, re.MULTILINE)]
    ),
    'status --json': _wrong_json,
    'events --journal FILE --format xes': _wrong_xes,
}
"""Those who look once, in turn, and what is wrong with what they were told."""
