"""A file is read again when it has changed, and only then."""

from __future__ import annotations

import os
from pathlib import Path

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.script.source_text import ReadOnce


class Reader:
    """Notes what is read; files with nothing in them say nothing."""

    def __init__(self) -> None:
        self.read: list[str] = []

    def __call__(self, path: Path) -> str:
        self.read.append(path.name)
        text = path.read_text()
        if not text:
            raise Refused([])
        return text


def test_what_stays_as_it_is_is_read_once(tmp_path: Path) -> None:
    reader = Reader()
    files, paths = ReadOnce(reader), [tmp_path / name for name in 'ab']
    for path, text in zip(paths, ('one', ''), strict=True):
        path.write_text(text)
    assert files.of([*paths, tmp_path / 'none']) == ['one']
    assert files.of(paths) == ['one']
    assert reader.read == ['a', 'b'], 'also what cannot be read'


def test_what_has_changed_is_read_again(tmp_path: Path) -> None:
    reader, path = Reader(), tmp_path / 'a'
    files = ReadOnce(reader)
    path.write_text('one')
    assert files.of([path]) == ['one']
    path.write_text('two')
    os.utime(path, (1.0, 1.0))
    assert files.of([path]) == ['two']
    path.unlink()
    assert files.of([path]) == []
