"""Which asyncua the overrides are for."""

from __future__ import annotations

import pytest

from bt_orchestrator.extensions.opcua.server import library
from bt_orchestrator.extensions.opcua.server.library import OpcUaUnusable, check_version


@pytest.mark.parametrize('found', ['2.0.9', '2.2.0', '3.0'])
def test_another_asyncua_is_refused(monkeypatch: pytest.MonkeyPatch, found: str) -> None:
    check_version()
    monkeypatch.setattr(library, 'version', lambda _: found)
    with pytest.raises(OpcUaUnusable, match=f'2.1.x is needed, and {found} is installed'):
        check_version()
