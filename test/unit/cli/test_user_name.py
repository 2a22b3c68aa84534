"""Who runs a program."""

from __future__ import annotations

import getpass

import pytest

from bt_orchestrator.cli.node_options import user_name


@pytest.mark.parametrize('error', [KeyError, OSError, ImportError])
def test_unnamed_user_id_is_shown_as_number(
    error: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As containers have it, which run programs under any user id."""

    def nobody() -> str:
        raise error('getpwuid(): uid not found: 12345')

    monkeypatch.setattr(getpass, 'getuser', nobody)
    monkeypatch.setattr('os.getuid', lambda: 12345)
    assert user_name() == 'user 12345'


def test_user_name_is_always_valid_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('LOGNAME', 'J\udcfcrgen')
    assert user_name() == 'J?rgen'
