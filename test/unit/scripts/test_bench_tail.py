"""The tail of the benchmark, which reads a log while servers write it."""

from __future__ import annotations

import importlib.util
import io
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
LINE = b'{"event": "ended", "component": "a"}\n'


class WrittenMeanwhile(io.RawIOBase):
    """A file of which one line is half written at the first look, and whole at the next one."""

    def __init__(self, text: bytes, half: int) -> None:
        self._text, self._ends = io.BytesIO(text), [half, half, len(text)]

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._text.seek(offset, whence)

    def readinto(self, buffer: Any) -> int:
        end = self._ends.pop(0) if len(self._ends) > 1 else self._ends[0]
        chunk = self._text.read(min(len(buffer), end - self._text.tell()))
        buffer[: len(chunk)] = chunk
        return len(chunk)


def _tail_module() -> Any:
    spec = importlib.util.spec_from_file_location('tail', ROOT / 'bench/tail.py')
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_half_written_line_is_read_once_complete(tmp_path: Path, monkeypatch: Any) -> None:
    log = tmp_path / 'log'
    log.touch()
    tail = _tail_module().Tail(log)
    file = io.BufferedReader(WrittenMeanwhile(LINE * 3, half=len(LINE) + 8))
    with monkeypatch.context() as patched:
        patched.setattr(Path, 'open', lambda *_: file)
        tail._read()
    log.write_bytes(LINE * 3)
    assert tail._read() == 3
