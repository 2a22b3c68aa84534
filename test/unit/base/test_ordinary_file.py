"""Reading a file that somebody named; as text: `script/test_source_text.py`."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from bt_orchestrator.base.ordinary_file import NotOrdinary, read_ordinary


def test_the_content_comes_up_to_a_limit(tmp_path: Path) -> None:
    path = tmp_path / 'a'
    path.write_bytes(b'x' * 2000)
    assert read_ordinary(path, 2000) == b'x' * 2000
    with pytest.raises(NotOrdinary, match=r'/a: the file is larger than 1 kB'):
        read_ordinary(path, 1999)


def test_pipes_and_devices_are_not_ordinary_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'link').symlink_to('/dev/zero')
    for path in (tmp_path / 'pipe', tmp_path / 'link', Path('/dev/full')):
        with pytest.raises(NotOrdinary) as refused:
            read_ordinary(path, 1000)
        assert refused.value.strerror == 'this is a pipe or a device, and no ordinary file'
        assert str(refused.value) == f'{path}: {refused.value.strerror}'


def test_other_errors_are_those_of_the_system(tmp_path: Path) -> None:
    (tmp_path / 'loop').symlink_to('loop')
    for path, reason in {'': 'Is a directory', 'none': 'No such file', 'loop': 'symbolic'}.items():
        with pytest.raises(OSError, match=reason):
            read_ordinary(tmp_path / path, 1000)
