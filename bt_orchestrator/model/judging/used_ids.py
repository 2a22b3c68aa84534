"""The used order ids, or serials: a set that stays small when they are counted up.

What does not count up is kept in parts: one is open, and when it is full it is sealed and never
changes again. So a record of the state has the open part, and names the sealed ones
(decision 0042).
"""

from __future__ import annotations

import hashlib
import json
import re
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

FULL = 4096
"""Entries (ids, and runs of them) with which a part is sealed: 80 kB, and some milliseconds."""

_COUNTED = re.compile(r'(?s)(.*?)(0|[1-9][0-9]{0,17})')
"""An id as a prefix and a number without leading zeros: `WO-007` is `WO-00` and 7."""


@dataclass
class UsedIds:
    """A set of ids that only grows.

    Numbers behind one prefix are kept as runs, so WO-1 to WO-100000 are two numbers and not a
    hundred thousand texts. An id that ends in no number is kept as it is.

    The content of sealed parts (`parts`, by digest) is no field. A state that was read without
    `open_parts`, to look back or forecast, knows their names, but not what is in them.
    """

    others: set[str] = field(default_factory=set)
    runs: dict[str, list[list[int]]] = field(default_factory=dict)
    """By prefix: first and last number of each run, ascending, with gaps between them."""
    sealed: list[str] = field(default_factory=list)
    """Digests of the sealed parts, oldest first."""

    def __post_init__(self) -> None:
        """Count what is in the open part."""
        self.parts: dict[str, SealedIds] = {}
        self._entries = len(self.others) + sum(map(len, self.runs.values()))

    def __contains__(self, name: str) -> bool:
        if name in self.others or self._is_sealed(name):
            return True
        counted = _COUNTED.fullmatch(name)
        return counted is not None and self._last_of_run(counted[1], int(counted[2])) >= 0

    def add(self, name: str) -> None:
        """Take an id in. Sealed parts are not asked: one that is in them is only kept twice."""
        counted = _COUNTED.fullmatch(name)
        if counted is None:
            self._entries += name not in self.others
            self.others.add(name)
        else:
            self._entries += _add(self.runs.setdefault(counted[1], []), int(counted[2]))
        self._seal_if_full()

    def free(self, prefix: str) -> Iterator[str]:
        """Yield the ids of a prefix and a number from 1 that were never used, ascending."""
        number = 1
        while True:
            last = self._last_of_run(prefix, number)
            name = f'{prefix}{number}'
            if last < 0 and not self._is_sealed(name):
                yield name
            number = max(number, last) + 1

    def open_parts(self, read: Callable[[str], str | None]) -> None:
        """Take in what is in the sealed parts, and seal what an older program kept in the open.

        :param read: returns the text of a digest; None: it is lost
        :raises KeyError: one is lost
        """
        for digest in self.sealed:
            text = read(digest)
            if text is None:
                raise KeyError(digest)
            self.parts[digest] = SealedIds(text)
        others, runs = self.others, self.runs
        if self._entries >= FULL:
            self._begin_part()
            for name in sorted(others):
                self.add(name)
            for prefix, run in ((prefix, run) for prefix, there in runs.items() for run in there):
                self.runs.setdefault(prefix, []).append(run)
                self._entries += 1
                self._seal_if_full()

    def _is_sealed(self, name: str) -> bool:
        """Tell whether an id is in a sealed part; runs aside."""
        line = line_of(name)
        return any(part.has(line) for part in self.parts.values())

    def _last_of_run(self, prefix: str, number: int) -> int:
        """Return the last number of the run that a number is in; -1: it is in none."""
        runs = self.runs.get(prefix, [])
        at = _run_at(runs, number)
        here = runs[at][1] if at >= 0 and number <= runs[at][1] else -1
        sealed = (part.last_of_run(prefix, number) for part in self.parts.values())
        return max(sealed, default=-1) if here < 0 else here

    def _seal_if_full(self) -> None:
        if self._entries < FULL:
            return
        alone, runs = set(self.others), {}
        for prefix, there in self.runs.items():
            alone.update(f'{prefix}{first}' for first, last in there if first == last)
            runs[prefix] = [run for run in there if run[0] < run[1]]
        part = SealedIds(
            text_of(alone, {prefix: there for prefix, there in runs.items() if there})
        )
        self.parts[part.digest] = part
        self.sealed.append(part.digest)
        self._begin_part()

    def _begin_part(self) -> None:
        self.others, self.runs, self._entries = set(), {}, 0


def _run_at(runs: list[list[int]], number: int) -> int:
    """Return the place of the last run that begins at a number or before; -1: none does."""
    return bisect_right(runs, number, key=lambda run: run[0]) - 1


def _add(runs: list[list[int]], number: int) -> int:
    """Put a number into a run, or between two; return how many runs more there are, or -1."""
    at = _run_at(runs, number)
    if at >= 0 and number <= runs[at][1]:
        return 0
    follows = at >= 0 and runs[at][1] == number - 1
    precedes = at + 1 < len(runs) and runs[at + 1][0] == number + 1
    if follows and precedes:
        runs[at][1] = runs.pop(at + 1)[1]
        return -1
    if follows:
        runs[at][1] = number
    elif precedes:
        runs[at + 1][0] = number
    else:
        runs.insert(at + 1, [number, number])
        return 1
    return 0


# A part of the ids that were ever used, which never changes again (decision 0042).
#
# A part is one text, named by its digest, and a sorted array of hashes to look into it quickly.
# So an id takes some 30 bytes, and no part of it is an object that the garbage collector looks
# at.


class SealedIds:
    """Ids, and runs of numbers behind a prefix, of one text."""

    def __init__(self, text: str) -> None:
        """Take in a text of `text_of`.

        :raises ValueError: it is no such text
        """
        self.text = text
        self.digest = digest_of(text)
        header, *lines = text.splitlines()
        self._hashes = array('q', sorted(map(hash, lines)))
        self._runs = {
            prefix: (array('q', (run[0] for run in runs)), array('q', (run[1] for run in runs)))
            for prefix, runs in json.loads(header).items()
        }

    def has(self, line: str) -> bool:
        """Tell whether it has an id, given as `line_of` writes it; runs aside."""
        wanted = hash(line)
        at = bisect_left(self._hashes, wanted)
        maybe = at < len(self._hashes) and self._hashes[at] == wanted
        return maybe and f'\n{line}\n' in self.text

    def last_of_run(self, prefix: str, number: int) -> int:
        """Return the last number of the run that a number is in; -1: it is in none."""
        runs = self._runs.get(prefix)
        if runs is None:
            return -1
        firsts, lasts = runs
        at = bisect_right(firsts, number) - 1
        return lasts[at] if at >= 0 and number <= lasts[at] else -1


def text_of(ids: Iterable[str], runs: Mapping[str, Sequence[Sequence[int]]]) -> str:
    """Return a part as text: the runs in its first line, then one id a line, sorted.

    :param runs: first and last number of each, ascending, by prefix
    """
    lines = [json.dumps(runs, sort_keys=True), *map(line_of, sorted(ids))]
    return '\n'.join(lines) + '\n'


def line_of(name: str) -> str:
    """Return the line of an id; JSON, for an id may hold any character."""
    return json.dumps(name)


def digest_of(text: str) -> str:
    """Return the name of a part."""
    return hashlib.sha256(text.encode()).hexdigest()[:32]
