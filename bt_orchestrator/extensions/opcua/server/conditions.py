"""Conditions as OPC UA events: facts of `mes.alarms`, and what people did about them.

They have no instances in the address space, because one costs 75 ms to make; a client gets them as
events, and names them by their ids.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime, timezone

from asyncua import ua

from bt_orchestrator.extensions.opcua.mes.alarms import Alarm, event_id
from bt_orchestrator.extensions.opcua.server.notices import Told
from bt_orchestrator.model.requests import ACKNOWLEDGE
from bt_orchestrator.model.requests.offers import role_words

TEXT, YES_NO, NODE = ua.VariantType.LocalizedText, ua.VariantType.Boolean, ua.VariantType.NodeId
TIME, WORD = ua.VariantType.DateTime, ua.VariantType.String

FOLDER = 'Conditions/'
"""Begin of the path of a condition; its key follows."""


@dataclass(frozen=True)
class Remark:
    """A remark of a person about a condition."""

    who: str
    words: str
    time: float


@dataclass(frozen=True)
class Standing:
    """A condition as the server shows it."""

    alarm: Alarm
    since: float
    """When it began; of those whose beginning is not on record, when it was first seen."""
    changed: float
    """The time of its last change."""
    is_active: bool = True
    is_acknowledged: bool = False
    remark: Remark | None = None
    """The last one."""

    def with_remark(self, word: str, remark: Remark) -> Standing:
        """Return it with what somebody said of it.

        :param word: acknowledge or comment
        """
        is_seen = self.is_acknowledged or word == ACKNOWLEDGE.word
        return replace(self, is_acknowledged=is_seen, remark=remark, changed=remark.time)

    def over(self, time: float, remark: Remark | None) -> Standing:
        """Return it as it ended: whoever ended it has seen it."""
        return replace(
            self, is_active=False, is_acknowledged=True, changed=time, remark=remark or self.remark
        )

    def id(self, history: str) -> bytes:
        """Return the EventId of what it says now."""
        remark = self.remark
        facts = (
            '' if self.is_active else 'over',
            'acknowledged' if self.is_acknowledged else '',
            '' if remark is None else f'{remark.who}: {remark.words}',
        )
        return event_id(history, self.alarm, '\0'.join(facts) if any(facts) else '')


@dataclass(frozen=True)
class Place:
    """Where conditions are, in the address space."""

    type_id: ua.NodeId
    idx: int
    cell: ua.NodeId
    cell_name: str

    def condition(self, key: str) -> ua.NodeId:
        """Return the ConditionId."""
        return ua.NodeId(f'{FOLDER}{key}', self.idx)

    def key(self, condition: ua.NodeId) -> str | None:
        """Return the thing that a ConditionId names; None: it is not an id of ours."""
        name = condition.Identifier
        if condition.NamespaceIndex != self.idx or not isinstance(name, str):
            return None
        return name.removeprefix(FOLDER) if name.startswith(FOLDER) else None

    def source(self, alarm: Alarm) -> tuple[ua.NodeId, str]:
        """Return the node that it is about, and its name."""
        if not alarm.source:
            return self.cell, self.cell_name
        kind, _, name = alarm.source.partition('/')
        return ua.NodeId(alarm.source, self.idx), f'section {name}' if kind == 'Sections' else name


def told(standing: Standing, history: str, place: Place) -> Told:
    """Return the event that says how a condition is now."""
    alarm = standing.alarm
    source, name = place.source(alarm)
    return Told(
        type_id=place.type_id,
        id=standing.id(history),
        source=source,
        source_name=name,
        time=standing.changed,
        message=_message(standing),
        severity=alarm.severity,
        fields=_fields(standing, place),
    )


def _message(standing: Standing) -> str:
    if standing.is_active:
        return standing.alarm.text
    remark = standing.remark
    how = f': {remark.who}: {remark.words}' if remark is not None else ''
    return f'over{how} ({standing.alarm.message})'


def _fields(standing: Standing, place: Place) -> Mapping[str, ua.Variant]:
    alarm, remark = standing.alarm, standing.remark
    return {
        'NodeId': ua.Variant(place.condition(alarm.key), NODE),
        'ConditionClassId': ua.Variant(ua.NodeId(ua.ObjectIds.ProcessConditionClassType), NODE),
        'ConditionClassName': _text('ProcessConditionClass'),
        'ConditionName': ua.Variant(alarm.key, WORD),
        'BranchId': ua.Variant(ua.NodeId(), NODE),
        'Retain': ua.Variant(standing.is_active, YES_NO),
        **_state('EnabledState', True, 'Enabled', 'Disabled', standing.since),
        'Quality': ua.Variant(ua.StatusCode(ua.StatusCodes.Good), ua.VariantType.StatusCode),
        'Quality/SourceTimestamp': _time(standing.since),
        'LastSeverity': ua.Variant(alarm.severity, ua.VariantType.UInt16),
        'LastSeverity/SourceTimestamp': _time(standing.since),
        'Comment': _text(remark.words if remark else ''),
        'Comment/SourceTimestamp': _time(remark.time if remark else standing.since),
        'ClientUserId': ua.Variant(remark.who if remark else '', WORD),
        **_state(
            'AckedState',
            standing.is_acknowledged,
            'Acknowledged',
            'Unacknowledged',
            standing.changed,
        ),
        **_state('ActiveState', standing.is_active, 'Active', 'Inactive', standing.since),
        'InputNode': ua.Variant(ua.NodeId(), NODE),
        'SuppressedOrShelved': ua.Variant(False, YES_NO),
        'Hold': ua.Variant(alarm.hold, WORD),
        'Answers': ua.Variant(list(alarm.answers), WORD, is_array=True),
        'AnswerRoles': ua.Variant(role_words(alarm.answers), WORD, is_array=True),
        'ReasonNumber': ua.Variant(alarm.reason.number, ua.VariantType.Int32),
        'ControllerSaid': ua.Variant(alarm.controller_said, WORD),
        'LastFeedback': ua.Variant(alarm.last_feedback, WORD),
    }


def _state(name: str, is_so: bool, yes: str, no: str, since: float) -> Mapping[str, ua.Variant]:
    return {
        name: _text(yes if is_so else no),
        f'{name}/Id': ua.Variant(is_so, YES_NO),
        f'{name}/TransitionTime': _time(since),
    }


def _text(words: str) -> ua.Variant:
    return ua.Variant(ua.LocalizedText(words), TEXT)


def _time(seconds: float) -> ua.Variant:
    return ua.Variant(datetime.fromtimestamp(seconds, timezone.utc), TIME)
