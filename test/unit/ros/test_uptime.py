"""What Linux tells of the boot of a machine."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from bt_orchestrator.ros.clock import MachineUptime

BOOT = '3f6d1c1e-9a3f-4a53-9d2b-6ad1a4d1e0c5'
NO_OFFSETS = 'monotonic           0         0\nboottime            0         0\n'


def proc(folder: Path, boot: str = BOOT, offsets: str | None = NO_OFFSETS) -> Path:
    """Return a folder that looks like /proc."""
    (folder / 'sys/kernel/random').mkdir(parents=True)
    (folder / 'sys/kernel/random/boot_id').write_text(f'{boot}\n')
    (folder / 'self').mkdir()
    if offsets is not None:
        (folder / 'self/timens_offsets').write_text(offsets)
    return folder


def test_boot_has_id_and_uptime_advances(tmp_path: Path) -> None:
    uptime = MachineUptime(proc(tmp_path))
    first, second = uptime.now(), uptime.now()
    assert first is not None
    assert second is not None
    assert first.boot == second.boot == BOOT
    assert 0.0 < first.seconds <= second.seconds


def test_an_old_kernel_has_no_time_namespaces(tmp_path: Path) -> None:
    assert MachineUptime(proc(tmp_path, offsets=None)).now() is not None


def test_unreadable_clock_gives_no_uptime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    uptime = MachineUptime(proc(tmp_path))

    def no_clock(number: int) -> float:
        raise OSError(errno.EINVAL, 'Invalid argument')

    monkeypatch.setattr('time.clock_gettime', no_clock)
    assert uptime.now() is None


def test_nothing_is_known_without_the_files(tmp_path: Path) -> None:
    assert MachineUptime(tmp_path).now() is None


def test_nothing_is_known_where_the_id_is_empty(tmp_path: Path) -> None:
    assert MachineUptime(proc(tmp_path, boot='')).now() is None


def test_container_with_own_time_has_no_uptime(tmp_path: Path) -> None:
    offsets = 'monotonic           0         0\nboottime       86400         0\n'
    assert MachineUptime(proc(tmp_path, offsets=offsets)).now() is None
