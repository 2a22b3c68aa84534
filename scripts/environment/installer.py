"""Puts wheels into an environment: with uv where PyPI has it for this machine, else with pip.

uv fetches many packages at a time and takes a tenth of pip's time. It knows nothing of pip's
settings, so where pip has been told of a mirror or a proxy, pip does the work.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from commands import clean_environment, run_logged
from report import Failure, say

PIP_ONLY = ('.index-url', '.no-index', '.proxy')
"""Settings of pip after which uv would look in the wrong place."""

EXACTLY = ('--no-deps', '--no-build-isolation')
"""What is named, built by what is installed."""

BY_HASH = '--require-hashes'
"""Nothing without a hash, even if a list has lost one."""

UV_OPTIONS = ('--link-mode', 'copy', '--compile-bytecode')
"""Copies: an edit in the environment must not reach others through uv's cache. Compiled:
where Python may not write files, each process compiles what it imports, 1 s of CPU for a node."""

Command = Sequence['str | Path']


class Installer:
    """Installs into the environment of `python`; `logs` is where its output goes."""

    def __init__(self, python: Path, logs: Path) -> None:
        self._python = python
        self._logs = logs
        self._uv = python.with_name('uv')
        self._pip: Command = [python, '-m', 'pip']

    def prepare(self, pins: Path) -> None:
        """Bring uv and pip into a new environment, as `pins` name them.

        A pip beside the interpreter saves the time to install one, but not every one has it.
        """
        outside: Command = [sys.executable, '-m', 'pip', '--python', self._python]
        if find_spec('pip') and self._fetch_uv(outside, pins):
            return
        self._run('ensurepip', self._python, '-m', 'ensurepip', exactly=())
        if not self._fetch_uv(self._pip, pins):
            say('without uv, which takes longer; pip has settings of its own, or no uv for here')

    def _fetch_uv(self, pip: Command, pins: Path) -> bool:
        if _has_settings(pip):
            return False
        try:
            # As a wheel only: building it takes a compiler for Rust, and many minutes.
            self._run('uv', *pip, 'install', '--only-binary', ':all:', BY_HASH, '-r', pins)
        except Failure:
            return False
        return self._uv.exists()

    def install_lists(self, log: str, *lists: Path) -> None:
        """Install exactly what the lists name; a file of another hash is refused."""
        self._install(log, BY_HASH, *(part for path in lists for part in ('-r', path)))

    def install_wheels(self, log: str, *wheels: Path) -> None:
        """Install these wheels in place of others of their name and version."""
        self._install(log, '--force-reinstall', *wheels)  # uv knows this name of it too

    def _install(self, log: str, *what: str | Path) -> None:
        if self._uv.exists():
            try:
                self._run(log, self._uv, 'pip', 'install', *UV_OPTIONS, *what)
                return
            except Failure:
                say(f'uv failed, see {self._logs / log}.log; once more with pip')
        self._run(f'{log}.pip', *self._pip, 'install', *what)

    def _run(self, log: str, *command: str | Path, exactly: Sequence[str] = EXACTLY) -> None:
        variables = {'VIRTUAL_ENV': str(self._python.parents[1])}  # where uv installs to
        run_logged(self._logs / f'{log}.log', *map(str, (*command, *exactly)), variables=variables)


def _has_settings(pip: Command) -> bool:
    listed = subprocess.run(
        [*map(str, pip), 'config', 'list'],
        check=False,
        capture_output=True,
        text=True,
        env=clean_environment(),
    )
    return any(line.split('=')[0].endswith(PIP_ONLY) for line in listed.stdout.splitlines())
