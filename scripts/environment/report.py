"""What the user gets to see, on stderr: scripts that print results run the bootstrap first.

On a terminal the line of a step is written again and again; elsewhere a step that takes long
gets a line now and then. Nothing is silent for longer than `SILENCE_S`.
"""

from __future__ import annotations

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

SILENCE_S = 4.0
REDRAW_S = 0.25


class Failure(Exception):
    """Something the user has to act on; the text says what."""


def say(text: str) -> None:
    print(f'bootstrap: {text}', file=sys.stderr, flush=True)


@contextmanager
def step(text: str, find_logs: Callable[[], list[Path]]) -> Iterator[None]:
    """Show that `text` is being done, for how long, and the last line that any log got."""
    started = time.monotonic()
    over = threading.Event()
    watcher = threading.Thread(target=_show, args=(text, started, find_logs, over), daemon=True)
    watcher.start()
    try:
        yield
    except BaseException:
        _end(watcher, over, f'{text}: failed after {_since(started)}')
        raise
    _end(watcher, over, f'{text}: {_since(started)}')


def last_line(logs: list[Path]) -> str:
    """Return what the log that was written last ends with; nothing while there is none."""
    try:
        newest = max(logs, key=lambda path: path.stat().st_mtime)
        lines = newest.read_text(errors='replace').splitlines()
    except (OSError, ValueError):  # none, or just being thrown away
        return ''
    text = next((line.strip() for line in reversed(lines) if line.strip()), '')
    return text.split(' (from ')[0]  # pip's reason


def _show(
    text: str, started: float, find_logs: Callable[[], list[Path]], over: threading.Event
) -> None:
    terminal = sys.stderr.isatty()
    _write(f'{text} ...', terminal)
    while not over.wait(REDRAW_S if terminal else SILENCE_S):
        now = f'{text}: {_since(started)}'
        _write(f'{now}  {last_line(find_logs())}'.rstrip(), terminal)


def _end(watcher: threading.Thread, over: threading.Event, text: str) -> None:
    over.set()
    watcher.join()
    terminal = sys.stderr.isatty()
    _write(text, terminal)
    if terminal:
        print(file=sys.stderr, flush=True)


def _write(text: str, terminal: bool) -> None:
    line = f'bootstrap: {text}'
    if terminal:
        line = line[: shutil.get_terminal_size().columns - 1]
    end, start = ('', '\r\x1b[K') if terminal else ('\n', '')
    print(f'{start}{line}', file=sys.stderr, end=end, flush=True)


def _since(started: float) -> str:
    return f'{time.monotonic() - started:.0f} s'
