"""The shell completes command lines, as bash does it when a person presses the Tab key."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bt_orchestrator.cli.completion import SHELLS
from bt_orchestrator.view.screen.advice import PROGRAM

FOLDER = Path(sys.executable).parent


def completed(line: str) -> list[str]:
    """Return what bash offers for the last word of a line."""
    script = f"""
        PATH={FOLDER}:$PATH
        source <({PROGRAM} completion bash)
        COMP_LINE='{line}' COMP_POINT={len(line)} COMP_TYPE=9
        COMP_WORDS=({line}) COMP_CWORD=1
        _python_argcomplete {PROGRAM}
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    done = subprocess.run(
        ['bash', '-c', script], capture_output=True, text=True, timeout=60, check=True
    )
    return [word.strip() for word in done.stdout.split('\n') if word.strip()]


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        (f'{PROGRAM} sub', ['submit']),
        (f'{PROGRAM} events --la', ['--last']),
        (f'{PROGRAM} answer 1 re', ['retry', 'reject']),
        (f'{PROGRAM} events --format x', ['xes']),
    ],
)
def test_bash(line: str, words: list[str]) -> None:
    assert sorted(completed(line)) == sorted(words)


@pytest.mark.parametrize('shell', SHELLS)
def test_every_shell_gets_words_that_it_understands(shell: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [FOLDER / PROGRAM, 'completion', shell], capture_output=True, text=True, check=True
    )
    assert PROGRAM in done.stdout
    executable = shutil.which(shell)
    if executable is not None:
        script = tmp_path / 'completion'
        script.write_text(done.stdout)
        subprocess.run([executable, '-n', str(script)], check=True)
