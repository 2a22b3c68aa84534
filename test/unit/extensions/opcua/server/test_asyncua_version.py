"""Which asyncua the overrides are for, and what comes with another one."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest
from fakes.opcua_access import access_in

from bt_orchestrator.extensions.opcua.server import library
from bt_orchestrator.extensions.opcua.server.library import OpcUaUnusable, why_plain
from bt_orchestrator.extensions.opcua.server.nodesets import AccessRefused


@pytest.mark.parametrize('version', ['2.0.9', '2.2.0', '2.10.0', '3.0'])
def test_the_inside_of_another_asyncua_is_left_alone(
    monkeypatch: pytest.MonkeyPatch, version: str
) -> None:
    assert why_plain() == ''
    monkeypatch.setattr(library, 'version', lambda _: version)
    assert why_plain() == f'asyncua {version} has another inside than 2.1.x, which is known'


def test_without_asyncua_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(library, 'version', version)
    with pytest.raises(OpcUaUnusable, match='asyncua is needed'):
        why_plain()


def test_the_plain_server_is_for_this_computer(tmp_path: Path) -> None:
    access = access_in(tmp_path, '/node', insecure=False, plain='asyncua 2.2')
    access.check()
    with pytest.raises(AccessRefused, match=r'^asyncua 2\.2; .* --host 0\.0\.0\.0'):
        replace(access, host='0.0.0.0').check()
