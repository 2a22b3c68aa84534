"""A part of the ids that were ever used, which never changes again (decision 0042).

A part is one text, named by its digest, and a sorted array of hashes to look into it quickly. So
an id takes some 30 bytes, and no part of it is an object that the garbage collector looks at.
"""

from __future__ import annotations

import hashlib
import json
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence


class SealedIds:
    """Ids, and runs of numbers behind a prefix, of one text."""

    def __init__(self, text: str) -> None:
        """Take in a text of `text_of`.

        :raises ValueError: it is no such text
        """
        self.text = text
        self.digest = digest_of(text)
        told, *lines = text.splitlines()
        self._hashes = array('q', sorted(map(hash, lines)))
        self._runs = {
            prefix: (array('q', (run[0] for run in runs)), array('q', (run[1] for run in runs)))
            for prefix, runs in json.loads(told).items()
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
