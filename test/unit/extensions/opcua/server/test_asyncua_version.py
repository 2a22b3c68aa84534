"""Which asyncua the overrides are for."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.server import asyncua_version
from bt_orchestrator.extensions.opcua.server.asyncua_version import OpcUaUnusable, check_version


@pytest.mark.parametrize('found', ['2.0.9', '2.2.0', '3.0'])
def test_another_asyncua_is_refused(monkeypatch: pytest.MonkeyPatch, found: str) -> None:
    check_version()
    monkeypatch.setattr(asyncua_version, 'version', lambda _: found)
    with pytest.raises(OpcUaUnusable, match=f'2.1.x is needed, and {found} is installed'):
        check_version()
