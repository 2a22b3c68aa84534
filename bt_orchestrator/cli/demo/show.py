"""The course of a demo in front of a person: submitting, looking, and when it is over."""

from __future__ import annotations

import contextlib
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.demo.programs import READY_S, DemoPrograms
from bt_orchestrator.cli.door import STEP_S, Ignoring
from bt_orchestrator.cli.node_options import origin
from bt_orchestrator.cli.ordering.order_request import for_node
from bt_orchestrator.cli.programs import ProgramFailed
from bt_orchestrator.model.by import By
from bt_orchestrator.model.events import Event, JobAborted, JobCompleted
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.ports import CellLink
from bt_orchestrator.view.screen.advice import Choice, Shell, hold_choices, next_choices
from bt_orchestrator.view.screen.keys import Keys
from bt_orchestrator.view.screen.plain import EventLines

if TYPE_CHECKING:  # it needs rich, which takes its time
    from bt_orchestrator.view.screen.live import LiveView


class Interrupted(Exception):
    """Somebody wants the demo to end."""


class DemoShow(Ignoring):
    """One order on a line whose programs run."""

    def __init__(
        self,
        programs: DemoPrograms,
        viewer: LiveView | EventLines,
        dialogue: Dialogue,
        stop: StopSignals,
    ) -> None:
        self._programs = programs
        self._viewer = viewer
        self._dialogue = dialogue
        self._stop = stop
        self._heard: CellStatus | None = None
        self._job = ''
        self._ended: set[str] = set()

    def look(self) -> None:
        """Do what has to be done all the time, whatever is waited for.

        :raises ProgramFailed: the tree node has gone
        :raises Interrupted: somebody wants an end
        """
        if self._stop.requested:
            raise Interrupted
        self._programs.check()
        if self._job and self._of_job() is not None:  # what came before it is over soon
            self._dialogue.look(self._status)
        about = (*self._programs.about_servers(), self._programs.about_node())
        self._viewer.on_notes([*self._dialogue.lines(), *about])
        self._viewer.refresh()

    def follow(
        self, door: CellLink, order: WorkOrder, *, asks: bool, stays: bool = False
    ) -> tuple[str, Sequence[Hold]]:
        """Give the order unless it is there, and look until nothing goes on.

        :param asks: a hold does not end the demo
        :param stays: only somebody who wants an end ends it
        :return: the id of its job, and what is held
        """
        door.follow(self)
        self._wait_for_servers(door)
        self._job = self._ordered(door, order)
        while not self._is_over(asks=asks):
            door.turn(STEP_S)
        with contextlib.suppress(Interrupted):
            while stays:
                door.turn(STEP_S)
        return self._job, self._status.holds

    def on_status(self, status: CellStatus) -> None:
        """Show a status that knows the order: what a cell without one waits for is no news."""
        self._heard = status
        if self._job and self._of_job() is not None:
            self._viewer.on_status(status)

    def on_event(self, event: Event) -> None:
        """Show what happened, and notice the end of a job."""
        self._viewer.on_event(event)
        if isinstance(event, JobCompleted | JobAborted):
            self._ended.add(event.job)

    def _wait_for_servers(self, door: CellLink) -> None:
        deadline = time.monotonic() + READY_S
        while not self._all_are_there():
            if time.monotonic() > deadline:
                raise NodeUnreachable(
                    f'the node did not see all action servers within {READY_S:g} s; '
                    '`bt-orchestrator doctor` tells why'
                )
            door.turn(STEP_S)

    def _all_are_there(self) -> bool:
        return self._heard is not None and all(c.available for c in self._heard.components)

    def _ordered(self, door: CellLink, order: WorkOrder) -> str:
        """Return the id of the order's job, which a resumed demo has already."""
        if order.order in {job.id for job in self._status.jobs}:
            return str(order.order)
        answer = door.ask(ask('queue.add', By('', origin(), ''), orders=[for_node(order)]))
        findings = [finding for order_answer in answer.orders for finding in order_answer.findings]
        if not answer.accepted:
            raise ProgramFailed('\n'.join([answer.message, *findings]))
        (queued,) = answer.orders
        return queued.job

    def _is_over(self, *, asks: bool) -> bool:
        """Tell whether the job has ended, or nothing goes on and no question is open."""
        job = self._of_job()
        ended = job is not None and job.state in OVER
        return (
            ended
            or self._job in self._ended
            or (not asks and self._status.state is PackmlState.HELD)
        )

    @property
    def _status(self) -> CellStatus:
        """How the cell stands; asked for when the node has said so."""
        assert self._heard is not None
        return self._heard

    def _of_job(self) -> JobStatus | None:
        """Return how the job stands; None: the node has not said so yet."""
        return next((job for job in self._status.jobs if job.id == self._job), None)


# The person in front of a demo: what is asked, which keys answer it, and what came of that.

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
            offered = (f'{number} {choice.name}' for number, choice in enumerate(self._choices, 1))
            yield f'press a key: {"   ".join(offered)}'

    def _offer(self, offer: tuple[Choice, ...]) -> None:
        if offer and offer != self._choices:
            self._said.clear()  # it was about something else
        self._choices = offer

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
    return tuple(choice for choice in offered if choice.is_complete and not choice.who)
