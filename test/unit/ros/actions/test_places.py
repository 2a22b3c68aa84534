"""Where an endpoint is, by its id."""

from __future__ import annotations

import os
from pathlib import Path

from bt_orchestrator.ros.actions.rivals import place

HOST = (7, 9)


def gid(pid: int, host: tuple[int, int] = HOST, vendor: int = 15) -> list[int]:
    return [1, vendor, *host, pid & 0xFF, (pid >> 8) & 0xFF, *range(18)]


OWN = gid(os.getpid())


def processes(folder: Path, *pids: int) -> Path:
    for pid in pids:
        (folder / str(pid)).mkdir()
    (folder / 'self').mkdir()
    return folder


def test_a_process_of_this_computer_is_named(tmp_path: Path) -> None:
    folder = processes(tmp_path, 10, 0x10000 + 300, 301)
    assert place(gid(0x10000 + 300), OWN, folder) == 'process 65836 on this computer'


def test_ended_or_ambiguous_process_is_on_this_computer(tmp_path: Path) -> None:
    folder = processes(tmp_path, 300, 0x10000 + 300)
    assert place(gid(300), OWN, folder) == 'on this computer'
    assert place(gid(17), OWN, folder) == 'on this computer'


def test_of_another_computer_no_process_is_told(tmp_path: Path) -> None:
    assert place(gid(300, (7, 8)), OWN, processes(tmp_path, 300)) == 'on another computer'


def test_ids_that_do_not_tell_are_not_read(tmp_path: Path) -> None:
    folder = processes(tmp_path, 300)
    assert place(gid(300, vendor=16), OWN, folder) == ''
    assert place(gid(300), gid(os.getpid(), vendor=16), folder) == ''
    # Its own id does not have its own process: the layout is another one.
    assert place(gid(300), gid(os.getpid() + 1), folder) == ''
    assert place([], [], folder) == ''
