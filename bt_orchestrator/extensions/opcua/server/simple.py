"""The flat part: for clients that cannot build structures, and for a first look."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.simple_commands import SimpleCommands
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.extensions.opcua.server.values import moment
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.requests.offers import role_words
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus, JobStatus, ManualGoal
from bt_orchestrator.model.wait import StandCause

TEXT, COUNT, TIME = ua.VariantType.String, ua.VariantType.UInt32, ua.VariantType.DateTime
FLAG = ua.VariantType.Boolean

TOP = 'Simple'

CONNECTED = 'the server hears the cell; while it does not, all other values are of before'


class Shown(NamedTuple):
    """A variable."""

    type: ua.VariantType
    meaning: str
    is_list: bool = False


CELL: Mapping[str, Shown] = {
    'State': Shown(TEXT, 'PackML state of the cell, for instance Execute or Held'),
    'StateSince': Shown(TIME, 'when the cell entered this state'),
    'StopReason': Shown(
        TEXT,
        'why the line stands still: operator, own_fault, starved, blocked, emergency; empty: it '
        'does not',
    ),
    'StopMessage': Shown(TEXT, 'the stop reason in words'),
    'StandsSince': Shown(TIME, 'since when nothing moves; null: something does'),
    'StandsCause': Shown(
        TEXT,
        f'root cause for which nothing moves: {", ".join(cause.value for cause in StandCause)}; '
        'empty: something moves',
    ),
    'StandsReason': Shown(TEXT, 'that cause in words'),
    'WaitsFor': Shown(TEXT, 'what lets the cell work again, in words; empty: nothing is needed'),
    'Queued': Shown(COUNT, 'jobs in the queue'),
    'Running': Shown(COUNT, 'jobs that have started and not ended'),
    'Safety': Shown(TEXT, 'ready, or why the safety input is not; empty: the cell has none'),
    'Control': Shown(TEXT, 'local: only the panels of the line may move it; or remote'),
    'UnitMode': Shown(TEXT, 'production; or manual: the cell stands, and runs single goals'),
    'Holds': Shown(COUNT, 'holds that wait for an answer'),
}

JOB: Mapping[str, Shown] = {
    'ID': Shown(TEXT, 'id of the job, as it was ordered; empty: there is none'),
    'Script': Shown(TEXT, 'name of its script'),
    'Recipe': Shown(TEXT, 'recipe that the script was generated from; empty: none'),
    'RecipeVersion': Shown(COUNT, 'version of the recipe; 0: none, or not known'),
    'RestOf': Shown(TEXT, 'job whose items it makes that this had not begun; empty: none'),
    'MadeAnew': Shown(
        TEXT, 'because of what its script was generated again, and the pace; empty: it was not'
    ),
    'State': Shown(
        TEXT, 'ISA-95 state, for instance Running, Interrupted/Held, Interrupted/Suspended, Ended'
    ),
    'Unavailable': Shown(
        TEXT,
        'components out of service that it needs: it is NotAllowedToStart, or its tasks wait',
        is_list=True,
    ),
    'AwaitsRelease': Shown(
        FLAG, 'its script was generated and is not released: it is NotAllowedToStart'
    ),
    'Ending': Shown(
        TEXT, 'stopping or aborting: it ends when its last item has left; empty: neither'
    ),
    'Planned': Shown(COUNT, 'items to make'),
    'Started': Shown(COUNT, 'items begun'),
    'Packed': Shown(COUNT, 'items packed, good or nonconforming'),
    'Good': Shown(COUNT, 'items packed that are not nonconforming'),
    'Rejected': Shown(COUNT, 'items that left the line as scrap'),
    'Nonconforming': Shown(COUNT, 'packed items that passed a failed task'),
    'Missing': Shown(COUNT, 'items that left the line as empty positions'),
    'StartTime': Shown(TIME, 'when it left the queue'),
    'EndTime': Shown(TIME, 'when its last item had left; before, when that is expected'),
}

HOLD: Mapping[str, Shown] = {
    'ID': Shown(TEXT, 'id of the hold, for AnswerHold; empty: there is none'),
    'Message': Shown(TEXT, 'where something is held, what, and why'),
    'Job': Shown(TEXT, 'id of its job'),
    'Section': Shown(COUNT, 'section of the belt; 0: none'),
    'Item': Shown(TEXT, 'id of its item'),
    'Task': Shown(TEXT, 'id of its task in the script'),
    'Answers': Shown(TEXT, 'the answers that are possible now', is_list=True),
    'AnswerRoles': Shown(
        TEXT, 'the roles that may give each of Answers, in its order', is_list=True
    ),
    'Since': Shown(TIME, 'when it began'),
}

GOAL: Mapping[str, Shown] = {
    'Component': Shown(TEXT, 'component of the goal; empty: there was none since it was entered'),
    'Task': Shown(TEXT, 'task constant'),
    'State': Shown(
        TEXT, 'running, cancelling, or how it ended: done, or the reason of the failure'
    ),
    'Message': Shown(TEXT, 'why it failed, in words'),
    'Results': Shown(TEXT, 'fields of its result, as one JSON object'),
    'Who': Shown(TEXT, 'the person that asked for it'),
    'Reason': Shown(TEXT, 'why'),
    'StartTime': Shown(TIME, 'when it was sent'),
    'EndTime': Shown(TIME, 'when it ended; null: it has not'),
}

REASONS: Mapping[str, Shown] = {
    'Codes': Shown(TEXT, "codes of the plant's reasons for stops of the line", is_list=True),
    'Groups': Shown(TEXT, 'group of each of Codes; empty: none', is_list=True),
}
REASON_WORDS = Shown(TEXT, 'words of each of Codes in this language', is_list=True)

_NO_TIME = 0.0


class Simple:
    """Implements `part.Part`."""

    def __init__(self, bridge: Bridge, *, takes_commands: bool = True) -> None:
        self._bridge = bridge
        self._takes_commands = takes_commands

    async def build(self, space: Space) -> None:
        """Make the nodes."""
        self._space = space
        await space.object(TOP, 'the cell in plain values, and the commands of every day')
        connected = await space.variable(
            f'{TOP}/Connected',
            ua.VariantType.Boolean,
            CONNECTED,
        )
        space.values.tell_trust(connected)
        await self._make('', CELL)
        for name, meaning, shown in (
            ('CurrentJob', 'the job on the line; of several the one that entered first', JOB),
            ('NextJob', 'the first job of the queue', JOB),
            ('LastJob', 'the job that ended last', JOB),
            ('OldestHold', 'the hold that has waited longest', HOLD),
            ('Manual', 'the goal of manual mode, or the last one', GOAL),
        ):
            await space.object(f'{TOP}/{name}', meaning)
            await self._make(f'{name}/', shown)
        await self._make_reasons()
        if self._takes_commands:
            await SimpleCommands(self._bridge).build(space, TOP)

    async def _make(self, prefix: str, shown: Mapping[str, Shown]) -> None:
        for name, variable in shown.items():
            path = f'{TOP}/{prefix}{name}'
            await self._space.variable(
                path, variable.type, variable.meaning, is_list=variable.is_list
            )

    async def _make_reasons(self) -> None:
        """Make the reasons of the plant: they come from a file, and never change."""
        await self._space.object(f'{TOP}/Reasons', 'reasons of the plant for stops of the line')
        reasons = self._bridge.sources.reasons.values()
        languages = dict.fromkeys(name for reason in reasons for name in reason.words)
        await self._make('Reasons/', {**REASONS, **dict.fromkeys(languages, REASON_WORDS)})
        columns = {
            'Codes': [reason.code for reason in reasons],
            'Groups': [reason.group for reason in reasons],
        }
        columns |= {name: [reason.said(name) for reason in reasons] for name in languages}
        for name, column in columns.items():
            node = self._space.node(f'{TOP}/Reasons/{name}')
            self._space.values.put(node, column, time.time(), is_own=True)

    def show(self, status: CellStatus) -> None:
        """Show a new status."""
        for path, value in values(status):
            self._space.values.put(self._space.node(f'{TOP}/{path}'), value, status.stamp)

    def hear(self, event: Event) -> None:
        """Nothing here comes from events."""

    def begin(self, history: str) -> None:
        """The next status tells all."""


def values(status: CellStatus) -> Iterator[tuple[str, object]]:
    """Yield the values of a status by the paths of their nodes."""
    running = [job for job in status.jobs if job.started_at is not None and job.state not in OVER]
    yield 'State', status.state.value
    yield 'StateSince', moment(status.state_since)
    yield 'StopReason', '' if status.stop_reason is None else status.stop_reason.value
    yield 'StopMessage', status.stop_message
    stands = status.stands
    yield 'StandsSince', None if stands is None else moment(stands.since)
    yield 'StandsCause', '' if stands is None else stands.cause.value
    yield 'StandsReason', '' if stands is None else stands.reason
    yield 'WaitsFor', status.waits_for
    yield 'Queued', status.queued
    yield 'Running', len(running)
    yield 'Safety', status.safety
    yield 'Control', status.control.value
    yield 'UnitMode', status.unit_mode.value
    yield 'Holds', len(status.holds)
    over = [job for job in status.jobs if job.state in OVER]
    queued = [job for job in status.jobs if job.position == 1]
    yield from _job('CurrentJob', min(running, key=_began, default=None), status)
    yield from _job('NextJob', queued[0] if queued else None, status)
    yield from _job('LastJob', max(over, key=_ended, default=None), status)
    yield from _hold(next(iter(status.holds), None))
    yield from _goal(status.manual)


def _goal(goal: ManualGoal | None) -> Iterator[tuple[str, object]]:
    values: tuple[object, ...] = ('', '', '', '', '', '', '', None, None)
    if goal is not None:
        values = (
            goal.component,
            goal.task,
            goal.state,
            goal.message,
            json_of(goal.results),
            goal.who,
            goal.reason,
            moment(goal.started),
            None if goal.ended is None else moment(goal.ended),
        )
    yield from zip((f'Manual/{name}' for name in GOAL), values, strict=True)


def _began(job: JobStatus) -> float:
    return job.started_at or _NO_TIME


def _ended(job: JobStatus) -> float:
    return job.ended_at or _NO_TIME


def _job(name: str, job: JobStatus | None, status: CellStatus) -> Iterator[tuple[str, object]]:
    shown_job = job or NO_JOB
    end = shown_job.ended_at
    if end is None and shown_job.expected_end_s is not None:
        end = round(status.stamp + shown_job.expected_end_s)
    facts = (
        shown_job.id,
        shown_job.script,
        shown_job.recipe,
        shown_job.recipe_version or 0,
        shown_job.rest_of,
        '' if shown_job.anew is None else shown_job.anew.words,
        shown_job.state.value if job else '',
        list(shown_job.unavailable),
        shown_job.awaits_release,
        shown_job.ending,
        shown_job.quantity,
        shown_job.started,
        shown_job.packed,
        shown_job.good,
        shown_job.rejected,
        shown_job.nonconforming,
        shown_job.missing,
        None if shown_job.started_at is None else moment(shown_job.started_at),
        None if end is None else moment(end),
    )
    yield from ((f'{name}/{key}', value) for key, value in zip(JOB, facts, strict=True))


def _hold(hold: Hold | None) -> Iterator[tuple[str, object]]:
    facts = ('', '', '', 0, '', '', [], [], None) if hold is None else (
        hold.id, hold_words(hold), hold.job or '', hold.section or 0, hold.item or '',
        hold.task or '', list(hold.answers), role_words(hold.answers), moment(hold.since),
    )  # fmt: skip
    yield from ((f'OldestHold/{key}', value) for key, value in zip(HOLD, facts, strict=True))


NO_JOB = JobStatus('', '', OVER[0])
