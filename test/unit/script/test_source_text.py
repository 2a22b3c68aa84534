"""Reading a user's file as text."""

from __future__ import annotations

import fcntl
import os
import signal
import time
from pathlib import Path

import pytest

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.script import source_text
from bt_orchestrator.script.source_text import read_text


def refusal(path: Path) -> str:
    with pytest.raises(Refused) as caught:
        read_text(path)
    (finding,) = caught.value.findings
    assert finding.file == str(path)
    return str(finding).removeprefix(f'{path}:')


def test_a_file_is_read_as_utf8(tmp_path: Path) -> None:
    (tmp_path / 'a.yaml').write_bytes('größe: 1\r\n'.encode())
    assert read_text(tmp_path / 'a.yaml') == 'größe: 1\r\n'


def test_a_missing_file_is_told_with_its_neighbour(tmp_path: Path) -> None:
    (tmp_path / 'process.yaml').touch()
    assert refusal(tmp_path / 'proces.yaml') == (
        '1:1: the file does not exist; did you mean `process.yaml`?'
    )
    (tmp_path / 'gear.svg').touch()
    assert refusal(tmp_path / 'gear') == '1:1: the file does not exist; check the path'
    assert refusal(tmp_path / 'x.yml') == '1:1: the file does not exist; check the path'


def test_a_missing_folder_is_told(tmp_path: Path) -> None:
    folder = tmp_path / 'nowhere'
    assert refusal(folder / 'a.yaml') == (
        f'1:1: the file does not exist; there is no folder {folder} either'
    )


def test_a_directory_is_no_file(tmp_path: Path) -> None:
    assert refusal(tmp_path) == '1:1: this is a directory; name the YAML file in it'


def test_a_file_as_folder_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / 'a').touch()
    assert 'the file cannot be read: Not a directory' in refusal(tmp_path / 'a' / 'b.yaml')


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'a')
    message = '1:1: this is a pipe or a device, and no ordinary file; save it as a file'
    assert refusal(tmp_path / 'a') == message
    assert refusal(Path('/dev/zero')) == message


def test_file_leased_by_another_process_does_not_block(tmp_path: Path) -> None:
    path = tmp_path / 'a.yaml'
    path.write_text('a: 1')
    leased = os.open(path, os.O_RDWR)
    before = signal.signal(signal.SIGIO, signal.SIG_IGN)
    try:
        fcntl.fcntl(leased, fcntl.F_SETLEASE, fcntl.F_WRLCK)
        began = time.monotonic()
        assert 'the file cannot be read: ' in refusal(path)
        assert time.monotonic() - began < 10.0  # a lease is broken after 45 s
    finally:
        os.close(leased)
        signal.signal(signal.SIGIO, before)


def test_a_name_that_no_file_can_have() -> None:
    assert 'the file cannot be read' in refusal(Path('a\x00b'))
    assert 'File name too long' in refusal(Path('a' * 5000))


def test_bytes_that_are_not_utf8_have_a_place(tmp_path: Path) -> None:
    (tmp_path / 'a.yaml').write_bytes('a: 1\nä: '.encode() + b'\xff\n')
    assert refusal(tmp_path / 'a.yaml') == ('2:4: the file is not UTF-8 text; save it as UTF-8')


def test_a_large_file_is_not_read_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_text, 'LARGEST_FILE', 1_000_000)
    (tmp_path / 'a.yaml').write_bytes(b' ' * 1_000_001)
    assert refusal(tmp_path / 'a.yaml') == (
        '1:1: the file is larger than 1 MB; is this the right file?'
    )
