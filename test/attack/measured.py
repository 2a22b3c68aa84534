"""What the foreign clock has measured, in figures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from attack.foreign_clock import PINGS, SAMPLES

MB = 1e6


@dataclass
class Figures:
    """Of one phase. Times in milliseconds."""

    pings: int = 0
    p50_ms: float = 0.0
    p99_ms: float = 0.0
    max_ms: float = 0.0
    """The slowest answer, or the longest silence."""
    plain_max_ms: float = 0.0
    """The same of the plain node beside it."""
    excess_ms: float = 0.0
    """How much slower the node was than the plain one at the same time, at most."""
    silent_s: float = 0.0
    """The longest time without any answer."""
    peak_mb: float = 0.0
    """Memory beyond that at the beginning."""
    grown_mb: float = 0.0
    journal_mb: float = 0.0


@dataclass
class Measured:
    """Everything that was measured so far."""

    folder: Path
    _pings: list[Mapping[str, Any]] = field(default_factory=list)
    _samples: list[Mapping[str, Any]] = field(default_factory=list)

    def read(self) -> None:
        """Read what the clock has written; its last line may be half written."""
        self._pings = _records(self.folder / PINGS)
        self._samples = _records(self.folder / SAMPLES)

    def answers_since(self, since: float) -> int:
        """Count the answers of the node to questions asked after a time."""
        self.read()
        return sum(
            p['who'] == 'node' and p['took'] is not None and p['at'] - p['took'] > since
            for p in self._pings
        )

    def between(self, begin: float, end: float, *, plain_too: bool = False) -> Figures:
        """Return the figures of a time.

        :param plain_too: whether the plain node was attacked in it, too
        """
        self.read()
        node, plain = (self._of(who, begin, end) for who in ('node', 'plain'))
        took = sorted(1e3 * p['took'] for p in node if p['took'] is not None)
        stats = Figures(pings=len(took))
        if took:
            stats.p50_ms, stats.p99_ms = took[len(took) // 2], took[len(took) * 99 // 100]
        stats.max_ms, stats.plain_max_ms = _longest_ms(node), _longest_ms(plain)
        stats.silent_s = max((p['silent'] for p in node), default=end - begin)
        stats.excess_ms = max((_length_ms(p) - _beside_ms(p, plain) for p in node), default=0.0)
        if plain_too:
            stats.excess_ms = min(stats.excess_ms, max(0.0, stats.max_ms - stats.plain_max_ms))
        self._add_sizes(stats, begin, end)
        return stats

    def _of(self, who: str, begin: float, end: float) -> list[Mapping[str, Any]]:
        return [p for p in self._pings if p['who'] == who and begin <= p['at'] <= end]

    def _add_sizes(self, figures: Figures, begin: float, end: float) -> None:
        samples = [s for s in self._samples if begin <= s['at'] <= end]
        if samples:
            first, last = samples[0], samples[-1]
            figures.peak_mb = max(s['mb'] for s in samples) - first['mb']
            figures.grown_mb = last['mb'] - first['mb']
            figures.journal_mb = (max(s['bytes'] for s in samples) - first['bytes']) / MB


def _records(file: Path) -> list[Mapping[str, Any]]:
    whole, _, _ = file.read_text().rpartition('\n') if file.exists() else ('', '', '')
    return [json.loads(line) for line in whole.splitlines()]


def _length_ms(ping: Mapping[str, Any]) -> float:
    """Return how long a question has taken, or has been open."""
    return 1e3 * float(ping['silent'] if ping['took'] is None else ping['took'])


def _longest_ms(pings: Sequence[Mapping[str, Any]]) -> float:
    return max(map(_length_ms, pings), default=0.0)


def _beside_ms(ping: Mapping[str, Any], others: Sequence[Mapping[str, Any]]) -> float:
    """Return the longest that others took while a ping was open."""
    begin, end = ping['at'] - _length_ms(ping) / 1e3, ping['at']
    near = [o for o in others if o['at'] >= begin and o['at'] - _length_ms(o) / 1e3 <= end]
    return _longest_ms(near)
