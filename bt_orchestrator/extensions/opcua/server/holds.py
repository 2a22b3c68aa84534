"""The part with the conditions: holds, and what else waits for people."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import NamedTuple

from asyncua import ua

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.mes.alarms import (
    EMERGENCY_KEY,
    Alarm,
    alarms_of,
    event_id,
    hold_key,
)
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.calls import Argument
from bt_orchestrator.extensions.opcua.server.condition_methods import ConditionMethods
from bt_orchestrator.extensions.opcua.server.conditions import Place, Remark, Standing, told
from bt_orchestrator.extensions.opcua.server.notices import Told
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.by import named
from bt_orchestrator.model.events import Event, HoldReleased, OperatorDecided, StopReasonChanged
from bt_orchestrator.model.requests import is_remark
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.stop_reason import StopReason

LOOK_BACK = 2_000
"""How many of the last events are searched for remarks about the holds that stand."""

log = logging.getLogger(__name__)

FIELDS = (
    Argument('Hold', ua.VariantType.String, 'id of the hold, for AnswerHold; empty: no hold'),
    Argument('Answers', ua.VariantType.String, 'the answers that it takes now', is_list=True),
    Argument(
        'AnswerRoles',
        ua.VariantType.String,
        'the roles that may give each of Answers, in its order',
        is_list=True,
    ),
    Argument(
        'ReasonNumber', ua.VariantType.Int32, 'of its reason, as ID of PackML/Admin/StopReason'
    ),
    Argument(
        'ControllerSaid',
        ua.VariantType.String,
        "text of the controller's own result; may be empty",
    ),
    Argument(
        'LastFeedback',
        ua.VariantType.String,
        'last feedback of the failed attempt as a JSON object; may be empty',
    ),
)


class _End(NamedTuple):
    seq: int
    time: float
    by: Remark | None
    """The act of a person that ended it."""


class Holds:
    """Implements `part.Part`.

    What stands comes from the node's status, and remarks about holds from its journal, so both
    come back when this server is started anew. Remarks about other conditions are known here only.
    """

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge
        self._history = bridge.history
        self._standing: dict[str, Standing] = {}
        self._ends: dict[str, _End] = {}
        """Ends that were heard of, by condition, until a status tells so."""
        self._leaving: set[str] = set()
        """Conditions that the last status did not have, though their end was not heard of yet."""
        self._last: Remark | None = None
        """The last decision of a person; what ends at its time, is ended by it."""

    async def build(self, space: Space) -> None:
        """Make the type, what conditions are about, and the methods."""
        self._space = space
        self._notices = space.notices
        base = ua.NodeId(ua.ObjectIds.AlarmConditionType)
        type_node = await space.event_type(
            'CellConditionType', base, FIELDS, 'something in the cell that waits for a person'
        )
        cell = self._bridge.description.cell
        self._place = Place(type_node.nodeid, space.idx, space.cell.nodeid, cell)
        await _make_sources(space, self._bridge)
        await self._recall()
        ConditionMethods(self, self._bridge.calls, space, self._place).install()

    def show(self, status: CellStatus) -> None:
        """Tell what has changed."""
        alarms = alarms_of(status)
        for key in [key for key in self._standing if key not in alarms]:
            is_told = bool(self._standing[key].alarm.hold) or key == EMERGENCY_KEY
            if is_told and key not in self._ends and key not in self._leaving:
                self._leaving.add(key)  # who ended it will be heard in a moment
            else:
                self._end(key, status)
        for key, alarm in alarms.items():
            before, end = self._standing.get(key), self._ends.get(key)
            if before is None or (end is not None and end.seq <= status.seq):
                self._ends.pop(key, None)  # of another one
                since = status.stamp if alarm.since is None else alarm.since
                self.put(Standing(alarm, since, since))
            elif before.alarm != alarm:
                self.put(_as_now(before, alarm, status.stamp))
        for key in self._ends.keys() - self._standing.keys():
            del self._ends[key]

    def hear(self, event: Event) -> None:
        """Remember who answered, and show what was remarked."""
        if isinstance(event, OperatorDecided):
            who = named(event.who, event.known)
            if event.hold and is_remark(event.answer):
                self._remark(event.hold, event.answer, Remark(who, event.reason, event.time))
                return
            why = f': {event.reason}' if event.reason else ''
            self._last = Remark(who, f'{event.answer}{why}', event.time)
        elif isinstance(event, HoldReleased):
            self._hear_end(hold_key(event.hold), event)
        elif (
            isinstance(event, StopReasonChanged)
            and event.stop_reason != StopReason.EMERGENCY.value
        ):
            self._hear_end(EMERGENCY_KEY, event)

    def _hear_end(self, key: str, event: Event) -> None:
        is_by_last = self._last is not None and self._last.time == event.time
        self._ends[key] = _End(event.seq, event.time, self._last if is_by_last else None)
        if key in self._leaving:
            self._end(key, self._bridge.status)

    def begin(self, history: str) -> None:
        """End all: the cell has another journal."""
        for key in list(self._standing):
            self._end(key, self._bridge.status)
        self._history = history
        self._last = None
        self._ends.clear()

    # --- what clients ask for ---------------------------------------------------------------

    def standing(self, key: str) -> Standing | None:
        """Return a condition; None: it is over, or there never was one."""
        return self._standing.get(key)

    def put(self, standing: Standing) -> None:
        """Show a condition from now on, and tell of it."""
        self._standing[standing.alarm.key] = standing
        self._tell(standing)

    def events(self) -> Iterator[Told]:
        """Yield all conditions as events, for a refresh."""
        for standing in self._standing.values():
            yield told(standing, self._history, self._place)

    def is_of(self, standing: Standing, event: bytes) -> bool:
        """Tell whether an EventId is that of a condition with its present facts."""
        return event in (standing.id(self._history), event_id(self._history, standing.alarm))

    # --- remarks ----------------------------------------------------------------------------

    def _remark(self, hold: str, word: str, remark: Remark) -> None:
        standing = self._standing.get(hold_key(hold))
        if standing is not None:
            self.put(standing.with_remark(word, remark))

    async def _recall(self) -> None:
        """Show what stands, with the remarks in the journal."""
        status = self._bridge.status
        self.show(status)
        seq = max(0, status.seq - LOOK_BACK) if status.holds else status.seq
        try:
            while seq < status.seq:
                page = await self._bridge.doors.events_after(seq)
                if not page.events:
                    break
                for event in page.events:
                    if isinstance(event, OperatorDecided) and is_remark(event.answer):
                        self.hear(event)
                seq = page.events[-1].seq
        except NodeUnreachable as error:
            log.warning('what was said about holds is not known: %s', error)

    # --- the end ----------------------------------------------------------------------------

    def _end(self, key: str, status: CellStatus) -> None:
        standing = self._standing.pop(key)
        self._leaving.discard(key)
        _, time, by = self._ends.pop(key, _End(status.seq, status.stamp, None))
        self._tell(standing.over(time, by))

    def _tell(self, standing: Standing) -> None:
        source, _ = self._place.source(standing.alarm)
        self._notices.tell(told(standing, self._history, self._place), source)


def _as_now(before: Standing, alarm: Alarm, stamp: float) -> Standing:
    since = before.since if alarm.since is None else alarm.since  # the clock may have been set
    return Standing(alarm, since, stamp, before.is_active, before.is_acknowledged, before.remark)


async def _make_sources(space: Space, bridge: Bridge) -> None:
    """Make what conditions are about: sections and components."""
    description = bridge.description
    await space.folder('Sections', 'positions of the belt, in the direction of travel')
    await space.folder('Components', 'device controllers')
    sections = {
        f'Sections/{n}': 'a position of the belt' for n in range(1, description.sections + 1)
    }
    components = {
        f'Components/{component.name}': component.action for component in description.components
    }
    for path, meaning in {**sections, **components}.items():
        node = await space.object(path, meaning)
        await node.set_event_notifier([ua.EventNotifier.SubscribeToEvents])
