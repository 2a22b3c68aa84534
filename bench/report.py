"""Runs in files and on a page."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from itertools import chain
from pathlib import Path
from typing import Any

from bench.rows import Row, percentile, shown

BEGIN, END = '<!-- figures of scripts/bench -->', '<!-- end -->'


def machine() -> str:
    """Say what this was measured on, and how busy that is."""
    cpu = re.search('model name\\s*: (.*)', Path('/proc/cpuinfo').read_text())
    parts = [
        f'{os.cpu_count()} cores ({cpu[1] if cpu else platform.machine()})',
        f'load {os.getloadavg()[0]:.1f}',
        f'Linux {platform.release()}',
        f'Python {platform.python_version()}',
    ]
    with suppress(PackageNotFoundError):
        parts.append(f'rclpy {version("rclpy")}')
    return ', '.join(parts)


def write(file: Path, rows: Sequence[Row], about: dict[str, Any]) -> None:
    """Keep a run."""
    file.write_text(json.dumps({**about, 'rows': [row.to_plain() for row in rows]}, indent=1))


def read(file: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return a run that was kept, and what was said about it."""
    plain = json.loads(file.read_text())
    rows = [Row(row['key'], row['rounds'], row['notes']) for row in plain.pop('rows')]
    return rows, plain


def put_on_page(
    page: Path, rows: Sequence[Row], about: Sequence[dict[str, Any]], plot: Path | None
) -> None:
    """Replace the figures between the marks of a Markdown file.

    :param plot: a picture to show there as well
    """
    text = page.read_text()
    before, after = text.partition(BEGIN)[0], text.partition(BEGIN)[2].partition(END)[2]
    parts = [
        _about(about),
        [''],
        _table(rows),
        _latencies(rows),
        _shown(page, plot),
        _figures(rows),
    ]
    lines = '\n'.join(chain.from_iterable(parts))
    page.write_text(f'{before}{BEGIN}\n{lines}{END}{after}')


def _about(runs: Sequence[dict[str, Any]]) -> Iterator[str]:
    for run in runs:
        measured = f'- {run["date"]}: `{run["command"]}`; {run["machine"]}'
        yield f'{measured}; load at the end {run["load"]}'


def _shown(page: Path, plot: Path | None) -> Iterator[str]:
    if plot is not None:
        place = os.path.relpath(plot, page.parent)
        yield f'![Dispatch latencies, and how costs grow]({place})'
        yield ''


def _table(rows: Sequence[Row]) -> Iterator[str]:
    heads = ('row', 'median', 'rounds: smallest .. largest', 'must', 'goal', 'holds')
    return _markdown(heads, map(_cells, rows))


def _cells(row: Row) -> Sequence[str]:
    target = row.target
    spread = f'{len(row.rounds)}: {row.spread}'
    must, goal = (target.in_words(bound) for bound in (target.must, target.goal))
    return target.name, shown(row.value), spread, must, goal, row.verdict


def _latencies(rows: Sequence[Row]) -> Iterator[str]:
    notes = next((row.notes for row in rows if 'latencies, s' in row.notes), None)
    if notes is None:
        return iter(())
    heads = ('candidate', 'sequence p50', 'p95', 'wrap p50', 'p95, all ms')
    both = {n: (values, notes['wraps, s'][n]) for n, values in notes['latencies, s'].items()}
    return _markdown(
        heads,
        (
            (name, *(f'{percentile(series, p) * 1e3:.2f}' for series in two for p in (0.5, 0.95)))
            for name, two in both.items()
        ),
    )


def _figures(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the figures behind the rows, except those that the table of latencies has."""
    figures = (
        (row.key, name, shown(value))
        for row in rows
        for name, value in row.notes.items()
        if isinstance(value, (int, float)) and not name.endswith(('p50, ms', 'p95, ms'))
    )
    return _markdown(('behind the row', 'figure', 'value'), figures)


def _markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    yield f'| {" | ".join(heads)} |'
    yield '|---' * len(heads) + '|'
    for cells in rows:
        yield f'| {" | ".join(cells)} |'
    yield ''
