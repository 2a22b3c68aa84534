"""A cell and its jobs as messages, and back: which facts, and what is not one to one."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Iterable, Iterator
from copy import copy
from typing import Any, Generic, TypeVar

from bt_orchestrator_interfaces import msg
from builtin_interfaces.msg import Time

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.commands import OrderAnswer
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.counting import good_of
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_record import FailureRecord, ItemRecord
from bt_orchestrator.model.jobs.order import MadeAnew, RecipeChoice
from bt_orchestrator.model.state import Hold, PassedTask
from bt_orchestrator.model.status import (
    BeltStatus,
    CellDescription,
    CellStatus,
    ComponentDescription,
    ComponentStatus,
    FinishedCycle,
    FlagStatus,
    ItemStatus,
    JobStatus,
    Leadership,
    ListedJob,
    ManualGoal,
    SectionStatus,
    StandbyStatus,
    TaskStatus,
)
from bt_orchestrator.model.stop_reason import Wish
from bt_orchestrator.model.wait import Stands, Wait
from bt_orchestrator.model.words import Words
from bt_orchestrator.ros.types.mapping import Codec, Mapped, flat, mapped, supplement

_Fact = TypeVar('_Fact')


def _nothing(_: object) -> dict[str, Any]:
    return {}


# --- parts ------------------------------------------------------------------------------------

for _kind in (
    Words,
    PassedTask,
    TaskStatus,
    Wait,
    Stands,
    FinishedCycle,
    FlagStatus,
    ManualGoal,
):
    mapped(_kind, getattr(msg, _kind.__name__))

_STANDBY = mapped(StandbyStatus, msg.StandbyStatus)
mapped(Leadership, msg.Leadership)

standby_message, standby_status = _STANDBY.write, _STANDBY.read


def _item(place: str) -> Codec:
    """Return the codec of an item whose fields begin with a word."""
    empty = f'{place}_empty_position'
    present = Codec(
        (empty,), lambda present: {empty: not present}, lambda it: not getattr(it, empty)
    )
    others = {name: f'{place}_{name}' for name in ('rejected', 'nonconforming')}
    return flat(ItemStatus, msg.SectionStatus, {'id': place, 'present': present, **others})


_SECTION = mapped(
    SectionStatus,
    msg.SectionStatus,
    {'number': 'section', 'slot': _item('slot'), 'item': _item('item')},
)
_COMPONENT = mapped(ComponentStatus, msg.ComponentStatus)
_HOLD = mapped(Hold, msg.HoldStatus)
mapped(ComponentDescription, msg.ComponentDescription, {'durations_s': 'durations'})
_DESCRIPTION = mapped(CellDescription, msg.CellDescription)

description_message = _DESCRIPTION.write
cell_description = _DESCRIPTION.read

# --- jobs -------------------------------------------------------------------------------------

_JOB_WORDS = {word: {'state': word.state, 'substate': word.substate} for word in JobWord}


def _by_hand(message: msg.JobStatus) -> int:
    """Derive how many items were taken off the belt by hand; of a job at work 1 may be lacking."""
    if message.ended_at != Time():
        return int(message.placed - message.packed - message.rejected)
    return max(int(message.missing + message.placed - message.started), 0)


_JOB = mapped(
    JobStatus,
    msg.JobStatus,
    {
        'state': Codec(
            ('state', 'substate'),
            _JOB_WORDS.__getitem__,
            lambda it: JobWord(f'{it.state}/{it.substate}'.rstrip('/')),
        ),
        'anew': flat(
            MadeAnew,
            msg.JobStatus,
            {
                'without': 'made_without',
                'back': 'made_with',
                'per_item_s': 'made_per_item_s',
                'before_s': 'made_before_s',
            },
            told_by='made_anew',
        ),
        'good': Codec((), _nothing, lambda it: good_of(it.packed, it.nonconforming)),
        'by_hand': Codec((), _nothing, _by_hand),
        **dict.fromkeys(
            ('end_unknown', 'first_piece', 'first_piece_state'),
            Codec((), _nothing, lambda _: ''),
        ),
    },
)
_JOB_FACTS = supplement(JobStatus, msg.JobFacts, {'id': 'job'})
"""The fields that the message about a job cannot carry, since it never changes."""
CHOICE = flat(RecipeChoice, msg.WorkOrder, {}, any_of=('recipes', 'version', 'bind'))
"""Of every message with these fields. A version or a binding without a recipe is read as well."""
_LISTED = mapped(
    ListedJob,
    msg.ListedJob,
    {
        'status': 'job',
        'details': Codec(
            ('details',),
            lambda details: {'details': json_of(details) if details else ''},
            lambda it: json.loads(it.details or '{}'),
        ),
        'choice': CHOICE,
    },
)

_ITEM_REPORT = supplement(
    ItemRecord,
    msg.ItemReport,
    {
        'item': 'id',
        'how': Codec(
            ('outcome',), lambda how: {'outcome': how or 'on_the_line'}, lambda it: it.outcome
        ),
    },
)
_FAILURE_REPORT = supplement(FailureRecord, msg.FailureReport, {'time': 'stamp'})

_ORDER_ANSWER = mapped(OrderAnswer, msg.OrderAnswer)

order_answer_message, order_answer = _ORDER_ANSWER.write, _ORDER_ANSWER.read
item_message, failure_message = _ITEM_REPORT.write, _FAILURE_REPORT.write
job_message, job_status = _JOB.write, _JOB.read
listed_message, listed_job = _LISTED.write, _LISTED.read

# --- the cell ---------------------------------------------------------------------------------


def _part(field: str, part: Mapped[Any]) -> Codec:
    """Return the codec of parts that a `StatusWriter` writes."""
    return Codec((field,), _nothing, lambda it: tuple(map(part.read, getattr(it, field))))


def _jobs(message: msg.Status) -> Iterator[JobStatus]:
    for job, facts in zip(message.jobs, message.job_facts, strict=True):
        yield changed(_JOB.read(job), **_JOB_FACTS.read(facts))


_STATUS = mapped(
    CellStatus,
    msg.Status,
    {
        'wish': flat(
            Wish,
            msg.Status,
            {
                'command': 'stopped_with',
                'who': 'stopped_by',
                'reason': 'stopped_why',
                'time': 'stopped_at',
                'known': 'stopped_known',
            },
        ),
        'belt': flat(
            BeltStatus,
            msg.Status,
            {name: f'belt_{name}' for name in ('moving', 'running', 'waits')},
        ),
        'initialization': 'initialization_waits',
        'sections': _part('sections', _SECTION),
        'components': _part('components', _COMPONENT),
        'jobs': Codec(('jobs', 'job_facts'), _nothing, lambda it: tuple(_jobs(it))),
        'holds': _part('holds', _HOLD),
    },
)

cell_status = _STATUS.read


class _Parts(Generic[_Fact]):
    """Messages about the parts of one kind; of a part that is as before, the one of before."""

    def __init__(
        self,
        name: Callable[[_Fact], Hashable],
        write: Callable[[_Fact], Any],
        write_anew: Callable[[_Fact, _Fact, Any], Any] | None = None,
    ) -> None:
        """Begin with none.

        :param write_anew: given a fact, what it was before and the message of before; None: as new
        """
        self._name = name
        self._write = write
        self._write_anew = write_anew or (lambda fact, _before, _message: write(fact))
        self._last: dict[Hashable, tuple[_Fact, Any]] = {}

    def messages(self, facts: Iterable[_Fact]) -> list[Any]:
        """Return the messages about some parts, in their order."""
        last, self._last = self._last, {}
        for fact in facts:
            known = last.get(name := self._name(fact))
            if known is None:
                known = fact, self._write(fact)
            elif known[0] != fact:
                known = fact, self._write_anew(fact, *known)
            self._last[name] = known
        return [message for _, message in self._last.values()]


_JobMessages = tuple[msg.JobStatus, msg.JobFacts]


def _write_job(job: JobStatus) -> _JobMessages:
    return _JOB.write(job), _JOB_FACTS.write(job)


def _write_job_anew(job: JobStatus, before: JobStatus, messages: _JobMessages) -> _JobMessages:
    """Write a job again; of one that only moved up in the queue, as all do, copy the rest."""
    if changed(before, position=job.position) != job:
        return _write_job(job)
    moved, facts = copy(messages[0]), messages[1]
    moved.position = job.position
    return moved, facts


class StatusWriter:
    """Writes one status after the other; what has not changed is not written again.

    Of a long line most has not: it saves four fifths of the time. A message shares its parts with
    those before and after it, so it must not be changed.
    """

    def __init__(self) -> None:
        self._sections = _Parts[SectionStatus](lambda section: section.number, _SECTION.write)
        self._components = _Parts[ComponentStatus](
            lambda component: component.name, _COMPONENT.write
        )
        self._jobs = _Parts[JobStatus](lambda job: job.id, _write_job, _write_job_anew)
        self._holds = _Parts[Hold](lambda hold: hold.id, _HOLD.write)

    def message(self, status: CellStatus) -> msg.Status:
        """Return the message with all that a status says."""
        message: msg.Status = _STATUS.write(status)
        message.sections = self._sections.messages(status.sections)
        message.components = self._components.messages(status.components)
        jobs = self._jobs.messages(status.jobs)
        message.jobs = [job for job, _ in jobs]
        message.job_facts = [facts for _, facts in jobs]
        message.holds = self._holds.messages(status.holds)
        return message
