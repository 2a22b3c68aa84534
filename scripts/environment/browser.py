"""Chromium of the operating system, for the gate of the page."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from report import Failure
from system import can_install, install

SHELL = 'chromium-headless-shell'
"""Chromium without its own windows: the same pages take less of a processor."""

NAMES = (SHELL, 'chromium', 'chromium-browser', 'google-chrome')
PACKAGES = (SHELL, 'fonts-dejavu-core')


def find_browser() -> str:
    """Return the path of a browser, the one of CHROMIUM first; empty if there is none."""
    own = os.environ.get('CHROMIUM', '')
    if own and not os.access(own, os.X_OK):
        raise Failure(f'CHROMIUM: expected the path of a browser, found {own}')
    return own or next(filter(None, map(shutil.which, NAMES)), '')


def install_missing_browser(log: Path) -> None:
    """Install Chromium where there is none and that is possible, else say what to do."""
    if find_browser():
        return
    if not can_install():
        raise Failure(
            'the gate of the page needs Chromium; install it and run this again:\n'
            f'    sudo apt-get install -y {" ".join(PACKAGES)}\n'
            'or set CHROMIUM to the path of one'
        )
    install(log, *PACKAGES)
    if not find_browser():
        raise Failure(f'apt-get succeeded, but PATH has none of {", ".join(NAMES)}')
