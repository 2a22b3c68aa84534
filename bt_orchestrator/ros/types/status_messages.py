"""The status of a cell as a message (bt_orchestrator_interfaces/msg/Status), and back."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, Generic, TypeVar

from bt_orchestrator_interfaces import msg

from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    BeltStatus,
    CellStatus,
    ComponentStatus,
    FlagStatus,
    JobStatus,
    SectionStatus,
)
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.model.wish import Wish
from bt_orchestrator.ros.stamps import from_time, to_time
from bt_orchestrator.ros.types.fact_messages import (
    job_facts_message,
    stands_message,
    stands_of,
    with_facts,
    words_message,
    words_of,
)
from bt_orchestrator.ros.types.job_messages import job_message, job_status
from bt_orchestrator.ros.types.part_messages import (
    component_message,
    component_status,
    hold_message,
    hold_of,
    section_message,
    section_status,
)
from bt_orchestrator.ros.types.task_messages import (
    task_message,
    task_status,
    wait_message,
    wait_of,
)

_Fact = TypeVar('_Fact')


class _Parts(Generic[_Fact]):
    """Messages about the parts of one kind; of a part that is as before, the one of before."""

    def __init__(self, name: Callable[[_Fact], Hashable], write: Callable[[_Fact], Any]) -> None:
        self._name = name
        self._write = write
        self._last: dict[Hashable, tuple[_Fact, Any]] = {}

    def messages(self, facts: Iterable[_Fact]) -> list[Any]:
        """Return the messages about some parts, in their order."""
        last, self._last = self._last, {}
        for fact in facts:
            known = last.get(name := self._name(fact))
            if known is None or known[0] != fact:
                known = fact, self._write(fact)
            self._last[name] = known
        return [message for _, message in self._last.values()]


class StatusWriter:
    """Writes one status after the other; what has not changed is not written again.

    Of a long line most has not: it saves four fifths of the time. A message shares its parts with
    those before and after it, so it must not be changed.
    """

    def __init__(self) -> None:
        self._sections = _Parts[SectionStatus](lambda section: section.number, section_message)
        self._components = _Parts[ComponentStatus](lambda one: one.name, component_message)
        self._jobs = _Parts[JobStatus](lambda job: job.id, _job_messages)
        self._holds = _Parts[Hold](lambda hold: hold.id, hold_message)

    def message(self, status: CellStatus) -> msg.Status:
        """Return the message with all that a status says."""
        wish, jobs = status.wish or Wish(''), self._jobs.messages(status.jobs)
        return msg.Status(
            stamp=to_time(status.stamp),
            seq=status.seq,
            history=status.history,
            cell=status.cell,
            state=status.state.value,
            stop_after=status.stop_after,
            stopped_by=wish.who,
            stopped_known=wish.known,
            stopped_with=wish.command,
            stopped_why=wish.reason,
            stopped_at=to_time(wish.time),
            waits_for=status.waits_for,
            journal_failure=status.journal_failure,
            disk_wait=status.disk_wait,
            state_since=to_time(status.state_since),
            state_times=[
                msg.StateTime(state=state.value, seconds=seconds)
                for state, seconds in status.state_times.items()
            ],
            stop_reason=status.stop_reason.value if status.stop_reason else '',
            stop_message=status.stop_message,
            stop_words=words_message(status.stop_words),
            stands=stands_message(status.stands),
            unauthenticated_role=(
                status.unauthenticated_role.value if status.unauthenticated_role else ''
            ),
            commands=status.commands,
            belt_moving=status.belt.moving,
            belt_running=[task_message(task) for task in status.belt.running],
            belt_waits=[wait_message(wait) for wait in status.belt.waits],
            initialization_waits=[wait_message(wait) for wait in status.initialization],
            sections=self._sections.messages(status.sections),
            components=self._components.messages(status.components),
            jobs=[job for job, _ in jobs],
            job_facts=[facts for _, facts in jobs],
            queued=status.queued,
            flags=[
                msg.FlagStatus(name=flag.name, count=flag.count, capacity=flag.capacity)
                for flag in status.flags
            ],
            holds=self._holds.messages(status.holds),
        )


def _job_messages(job: JobStatus) -> tuple[msg.JobStatus, msg.JobFacts]:
    return job_message(job), job_facts_message(job)


def cell_status(message: msg.Status) -> CellStatus:
    """Return all that a message says."""
    return CellStatus(
        cell=message.cell,
        stamp=from_time(message.stamp),
        seq=message.seq,
        history=message.history,
        state=PackmlState(message.state),
        state_since=from_time(message.state_since),
        state_times={PackmlState(one.state): one.seconds for one in message.state_times},
        stop_reason=StopReason(message.stop_reason) if message.stop_reason else None,
        stop_message=message.stop_message,
        stop_words=words_of(message.stop_words),
        stands=stands_of(message.stands),
        stop_after=message.stop_after,
        wish=_wish(message),
        waits_for=message.waits_for,
        unauthenticated_role=_role(message.unauthenticated_role),
        commands=tuple(message.commands),
        journal_failure=message.journal_failure,
        disk_wait=message.disk_wait,
        belt=BeltStatus(
            moving=message.belt_moving,
            running=tuple(map(task_status, message.belt_running)),
            waits=tuple(map(wait_of, message.belt_waits)),
        ),
        initialization=tuple(map(wait_of, message.initialization_waits)),
        sections=tuple(map(section_status, message.sections)),
        components=tuple(map(component_status, message.components)),
        jobs=tuple(_jobs(message)),
        queued=message.queued,
        flags=tuple(FlagStatus(one.name, one.count, one.capacity) for one in message.flags),
        holds=tuple(map(hold_of, message.holds)),
    )


def _jobs(message: msg.Status) -> Iterator[JobStatus]:
    for job, facts in zip(message.jobs, message.job_facts, strict=True):
        yield with_facts(job_status(job), facts)


def _wish(message: msg.Status) -> Wish | None:
    if not message.stopped_with:
        return None
    return Wish(
        message.stopped_with,
        message.stopped_by,
        message.stopped_why,
        from_time(message.stopped_at),
        message.stopped_known,
    )


def _role(word: str) -> Role | None:
    return Role(word) if word else None
