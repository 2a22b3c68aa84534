"""scripts/environment: the browser of the gate page."""

from __future__ import annotations

from pathlib import Path

import browser
import pytest
from browser import PACKAGES, find_browser, install_missing_browser
from fakes.programs import program
from report import Failure


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give the only folder on PATH."""
    monkeypatch.setenv('PATH', str(tmp_path))
    monkeypatch.delenv('CHROMIUM', raising=False)
    return tmp_path


def test_the_browser_on_path_is_taken(folder: Path) -> None:
    assert find_browser() == ''
    program(folder / 'google-chrome')
    assert find_browser() == str(folder / 'google-chrome')
    program(folder / 'chromium')
    assert find_browser() == str(folder / 'chromium')
    program(folder / 'chromium-headless-shell')
    assert find_browser() == str(folder / 'chromium-headless-shell')
    install_missing_browser(folder / 'log')
    assert not (folder / 'log').exists()


def test_an_own_browser_goes_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(folder / 'chromium')
    monkeypatch.setenv('CHROMIUM', str(program(folder / 'mine')))
    assert find_browser() == str(folder / 'mine')
    monkeypatch.setenv('CHROMIUM', str(folder / 'nothing'))
    with pytest.raises(Failure, match='CHROMIUM: expected the path of a browser'):
        find_browser()


def test_who_may_not_install_one_is_told_how(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('os.geteuid', lambda: 1000)
    program(folder / 'apt-get')
    with pytest.raises(Failure, match=f'sudo apt-get install -y {" ".join(PACKAGES)}'):
        install_missing_browser(folder / 'log')


def test_apt_get_brings_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('os.geteuid', lambda: 0)
    asked = folder / 'asked'
    program(folder / 'apt-get', f'echo "$@" >>{asked}')
    with pytest.raises(Failure, match='PATH has none of chromium'):
        install_missing_browser(folder / 'log')
    brought = folder / browser.NAMES[0]
    brings = f"printf '#!/bin/sh' >{brought}; /bin/chmod +x {brought}"
    program(folder / 'apt-get', f'echo "$@" >>{asked}; {brings}')
    install_missing_browser(folder / 'log')
    update, install = asked.read_text().splitlines()[-2:]
    assert update.endswith('update')
    assert install.endswith(f'install --no-install-recommends {" ".join(PACKAGES)}')
    assert find_browser() == str(brought)
