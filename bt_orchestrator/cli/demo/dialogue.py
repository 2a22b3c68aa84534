"""The person in front of a demo: what is asked, which keys answer it, and what came of that."""

from __future__ import annotations

import shlex
import subprocess
import sys
from collections.abc import Iterator, Sequence

from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.screen.advice import Choice, Shell, hold_choices, next_choices
from bt_orchestrator.view.screen.terminal.keys import Keys

REASON = 'decided in the demo'


class Dialogue:
    """Offers a key for each choice, and carries out what is pressed. A context.

    An answer is a verb of this program in a process of its own: what a key does is what the
    command line does that is shown.
    """

    def __init__(self, shell: Shell, keys: Keys | None) -> None:
        """Begin.

        :param keys: of the terminal; None: there is nobody to press any
        """
        self._shell = shell
        self._keys = keys
        self._choices: tuple[Choice, ...] = ()
        self._running: subprocess.Popen[str] | None = None
        self._said: list[str] = []

    def __enter__(self) -> Dialogue:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._running is not None:
            self._running.wait()

    def look(self, status: CellStatus) -> None:
        """Take note of what is asked now, press what was pressed, and hear what came of it."""
        self._hear()
        self._offer(choices(status))
        if self._keys is None:
            return
        for key in self._keys.pressed():
            if key.isdecimal() and 1 <= int(key) <= len(self._choices) and self._running is None:
                self._carry_out(self._choices[int(key) - 1])

    def lines(self) -> Iterator[str]:
        """Yield what the person has to know: what came of the last key, and the keys."""
        yield from self._said
        if self._running is None and self._choices and self._keys is not None:
            offered = (f'{number} {one.name}' for number, one in enumerate(self._choices, 1))
            yield f'press a key: {"   ".join(offered)}'

    def _offer(self, found: tuple[Choice, ...]) -> None:
        if found and found != self._choices:
            self._said.clear()  # it was about something else
        self._choices = found

    def _carry_out(self, choice: Choice) -> None:
        words = shlex.split(choice.words)
        reason = ['--reason', REASON] if choice.needs_reason else []
        self._said = [f'> {self._shell.program} {choice.words}']
        self._running = subprocess.Popen(
            [sys.executable, '-m', 'bt_orchestrator', *words, *reason],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def _hear(self) -> None:
        if self._running is None or self._running.poll() is None:
            return
        output, _ = self._running.communicate()
        self._said += [line for line in output.splitlines() if line.strip()]
        self._running = None


def choices(status: CellStatus) -> tuple[Choice, ...]:
    """Return what a key can do: an answer to the first hold, or the next step of the cell."""
    offered: Sequence[Choice] = next_choices(status)
    if status.holds:
        offered = hold_choices(status.holds[0], status.unauthenticated_role)
    return tuple(one for one in offered if one.is_complete and not one.who)
