"""Runs other programs."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping
from pathlib import Path

from report import Failure

# A sourced ROS 2 distribution, an active virtual environment, one of our own environments.
FOREIGN = ('PYTHON', 'AMENT_', 'CMAKE_', 'COLCON_', 'ROS_', '_ROS_', 'LD_', 'VIRTUAL_ENV')

NONE: Mapping[str, str] = {}


def clean_environment() -> dict[str, str]:
    """Return the variables of this process, without what would mix other packages in."""
    return {name: value for name, value in os.environ.items() if not name.startswith(FOREIGN)}


def run_logged(
    log: Path, *command: str, cwd: Path | None = None, variables: Mapping[str, str] = NONE
) -> None:
    """Write all output to `log`, of which a failure shows the end."""
    with log.open('w') as output:
        result = subprocess.run(
            command,
            check=False,
            cwd=cwd,
            env={**clean_environment(), **variables},
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    if result.returncode != 0:
        end = '\n'.join(log.read_text(errors='replace').splitlines()[-25:])
        raise Failure(f'{" ".join(command)}\nfailed; the end of {log}:\n{end}')


def base_interpreter(executable: str) -> str:
    """The real file behind a name, a link, a version manager's shim or a virtual environment."""
    code = (
        'import os, sys; (3, 10) <= sys.version_info[:2] <= (3, 13) or sys.exit(sys.version); '
        'print(os.path.realpath(getattr(sys, "_base_executable", sys.executable)))'
    )
    command = [executable, '-I', '-c', code]
    try:
        result = subprocess.run(command, check=False, capture_output=True, text=True)
    except OSError as error:
        raise Failure(f'--python {executable}: expected Python 3.10 to 3.13; {error}') from None
    if result.returncode != 0:
        found = result.stderr.strip()
        raise Failure(f'--python {executable}: expected Python 3.10 to 3.13, found {found}')
    return result.stdout.strip()
