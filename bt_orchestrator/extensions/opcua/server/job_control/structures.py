"""The structures of the nodeset, and ours; asyncua makes their classes from the nodeset."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import extensionobject_to_binary, struct_from_binary

from bt_orchestrator.extensions.opcua.server.values import moment
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.view.report.isa95.codes import State
from bt_orchestrator.view.report.isa95.job_order import RESOURCES, JobOrder
from bt_orchestrator.view.report.isa95.job_response import COUNTS, PACKED_QUANTITY, JobResponse
from bt_orchestrator.view.report.isa95.machinery import RUNS_PLANNED
from bt_orchestrator.view.report.isa95.parts import (
    Parameter,
    Text,
    WorkMaster,
    text_to_plain,
    texts_from_plain,
)

ORDER, RESPONSE = 'ISA95JobOrderDataType', 'ISA95JobResponseDataType'
LISTED, STATE = 'ISA95JobOrderAndStateDataType', 'ISA95StateDataType'
MASTER, PARAMETER = 'ISA95WorkMasterDataType', 'ISA95ParameterDataType'

_RESOURCE_TYPES = {
    'PersonnelRequirements': 'ISA95PersonnelDataType',
    'EquipmentRequirements': 'ISA95EquipmentDataType',
    'PhysicalAssetRequirements': 'ISA95PhysicalAssetDataType',
    'MaterialRequirements': 'ISA95MaterialDataType',
}

_COUNTS = (RUNS_PLANNED, *(name for name in COUNTS if name != PACKED_QUANTITY))
"""Sent as UInt32; clients know `PackedQuantity` as an Int64."""
_ENUMERATIONS = ('JobResult', 'JobExecutionMode')

NO_TIME = datetime(1970, 1, 1, tzinfo=timezone.utc)
"""Earlier moments stand for none, the 1st of January 1601 first of all."""

END_OF_TIME = datetime(9999, 12, 31, tzinfo=timezone.utc)
"""So do later ones: OPC UA has the last second of this day for a time without an end."""


# --- from clients -------------------------------------------------------------------------------


def order_from(structure: Any) -> JobOrder:
    """Return the job order that a client sent."""
    return JobOrder(
        structure.JobOrderID or '',
        _texts_from(structure.Description),
        tuple(_master_from(master) for master in structure.WorkMasterID or ()),
        _time_from(structure.StartTime),
        _time_from(structure.EndTime),
        structure.Priority,
        _parameters_from(structure.JobOrderParameters),
        **{
            field: tuple(plain_of(resource) for resource in getattr(structure, name) or ())
            for name, field in RESOURCES.items()
        },
    )


def states_from(structures: Iterable[Any]) -> list[State]:
    """Return the states that a client asks for; that of the order has no browse path."""
    return [
        State(
            structure.StateText.Text or '',
            structure.StateNumber,
            _machine_in(structure.BrowsePath),
        )
        for structure in structures
    ]


def comment_from(comments: Iterable[ua.LocalizedText]) -> str:
    """Return a comment, a list of localized texts: the first one, in whatever language."""
    return next((comment.Text for comment in comments if comment.Text), '')


def plain_of(value: Any) -> Any:
    """Return a structure of a resource as JSON, without what was not given."""
    if isinstance(value, ua.LocalizedText):
        return text_to_plain(_text_from(value))
    if isinstance(value, ua.Variant):
        return plain_of(value.Value)
    if isinstance(value, ua.EUInformation):
        return value.DisplayName.Text or ''
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, (list, tuple)):
        return [plain_of(element) for element in value]
    if dataclasses.is_dataclass(value):
        names = (field.name for field in dataclasses.fields(value) if field.name != 'Encoding')
        members = {name: plain_of(getattr(value, name)) for name in names}
        return {name: member for name, member in members.items() if member not in (None, '', [])}
    return value if isinstance(value, (bool, int, float, str)) or value is None else str(value)


def _master_from(structure: Any) -> WorkMaster:
    description = structure.Description
    return WorkMaster(
        structure.ID or '',
        '' if description is None else description.Text or '',
        _parameters_from(structure.Parameters),
    )


def _parameters_from(structures: Iterable[Any] | None) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            structure.ID or '',
            _value_from(structure.Value),
            _texts_from(structure.Description),
            ''
            if structure.EngineeringUnits is None
            else structure.EngineeringUnits.DisplayName.Text or '',
            _parameters_from(structure.Subparameters),
        )
        for structure in structures or ()
    )


def _value_from(variant: ua.Variant | None) -> object:
    value = None if variant is None else variant.Value
    if isinstance(value, (list, tuple)):
        return tuple(_text_from(element) if _is_text(element) else element for element in value)
    return _text_from(value) if _is_text(value) else value


def _is_text(value: object) -> bool:
    return isinstance(value, ua.LocalizedText)


def _text_from(text: Any) -> Text:
    return Text(text.Text or '', text.Locale or '')


def _texts_from(texts: Iterable[Any] | None) -> tuple[Text, ...]:
    return tuple(_text_from(text) for text in texts or ())


def _time_from(time: datetime | None) -> float | None:
    if time is None:
        return None
    aware = time if time.tzinfo is not None else time.replace(tzinfo=timezone.utc)
    return aware.timestamp() if NO_TIME < aware < END_OF_TIME else None


def _machine_in(path: Any) -> str:
    elements = path.Elements if path is not None else None
    return elements[-1].TargetName.Name or '' if elements else ''


# --- to clients ---------------------------------------------------------------------------------


class Structures:
    """Makes structures; names in browse paths are of the namespace of the nodeset."""

    def __init__(self, namespace: int) -> None:
        self._namespace = namespace

    def order(self, order: JobOrder) -> Any:
        """Return ISA95JobOrderDataType."""
        resources = {
            name: [
                _resource(_RESOURCE_TYPES[name], resource) for resource in getattr(order, field)
            ]
            for name, field in RESOURCES.items()
        }
        return _made(
            ORDER,
            JobOrderID=order.id,
            Description=_texts(order.description),
            WorkMasterID=[work_master(master) for master in order.work_masters],
            StartTime=_time(order.start),
            EndTime=_time(order.end),
            Priority=order.priority,
            JobOrderParameters=_parameters(order.parameters),
            **{name: structures or None for name, structures in resources.items()},
        )

    def order_and_state(self, order: JobOrder, states: Sequence[State]) -> Any:
        """Return ISA95JobOrderAndStateDataType."""
        return _made(LISTED, JobOrder=self.order(order), State=self.states(states))

    def response(self, response: JobResponse) -> Any:
        """Return ISA95JobResponseDataType."""
        description = response.description
        return _made(
            RESPONSE,
            JobResponseID=response.id,
            Description=None if description is None else _text(description),
            JobOrderID=response.order,
            StartTime=_time(response.start),
            EndTime=_time(response.end),
            JobState=self.states(response.states),
            JobResponseData=_parameters(response.data),
        )

    def states(self, states: Sequence[State]) -> list[Any]:
        """Return a list of ISA95StateDataType."""
        return [
            _made(
                STATE,
                BrowsePath=self._path(state.machine),
                StateText=ua.LocalizedText(state.text, 'en'),
                StateNumber=state.number,
            )
            for state in states
        ]

    def _path(self, machine: str) -> ua.RelativePath:
        """Return the path from the receiver to a sub-state machine; without one it is null."""
        if not machine:
            return ua.RelativePath()
        step = ua.RelativePathElement()
        step.ReferenceTypeId = ua.NodeId(ua.ObjectIds.HierarchicalReferences)
        step.IsInverse, step.IncludeSubtypes = False, True  # asyncua would go upwards
        step.TargetName = ua.QualifiedName(machine, self._namespace)
        path = ua.RelativePath()
        path.Elements = [step]
        return path


def none_of(name: str) -> Any:
    """Return a structure in which nothing stands, for the output of a call that failed."""
    return _made(name)


def listed(structures: Sequence[Any]) -> ua.Variant:
    """Return structures as one value; an empty list is one, too."""
    return ua.Variant(list(structures), ua.VariantType.ExtensionObject, is_array=True)


def encoded(structure: Any) -> ua.ExtensionObject:
    """Return a structure encoded for sending: no reader and no change encodes it again."""
    sent = Buffer(extensionobject_to_binary(structure))
    return struct_from_binary(ua.ExtensionObject, sent)


def work_master(master: WorkMaster) -> Any:
    """Return ISA95WorkMasterDataType."""
    return _made(
        MASTER,
        ID=master.id,
        Description=ua.LocalizedText(master.description) if master.description else None,
        Parameters=_parameters(master.parameters),
    )


def _made(name: str, **fields: Any) -> Any:
    return getattr(ua, name)(**fields)


def _parameters(parameters: Sequence[Parameter]) -> list[Any] | None:
    return [
        _made(
            PARAMETER,
            ID=_clean(parameter.id),
            Value=_variant(parameter.id, parameter.value),
            Description=_texts(parameter.description),
            EngineeringUnits=_unit(parameter.unit) if parameter.unit else None,
            Subparameters=_parameters(parameter.parts),
        )
        for parameter in parameters
    ] or None


def _variant(name: str, value: object) -> ua.Variant:
    """Return a value as it can be sent; what has no type of its own is sent as JSON."""
    if value is None:
        return ua.Variant()
    if not isinstance(value, tuple):
        type_ = _type(name, value)
        return ua.Variant(_sent(value, type_), type_)
    types = {_type(name, element) for element in value}
    type_ = types.pop() if len(types) == 1 else ua.VariantType.String
    return ua.Variant([_sent(element, type_) for element in value], type_, is_array=True)


def _type(name: str, value: object) -> ua.VariantType:
    if isinstance(value, int) and not isinstance(value, bool):
        if name in _COUNTS and 0 <= value < 2**32:
            return ua.VariantType.UInt32
        if name in _ENUMERATIONS and abs(value) < 2**31:
            return ua.VariantType.Int32
        return ua.VariantType.Int64 if abs(value) < 2**63 else ua.VariantType.String
    return _TYPES.get(type(value), ua.VariantType.String)


def _sent(value: object, type_: ua.VariantType) -> object:
    if isinstance(value, Text) and type_ is ua.VariantType.LocalizedText:
        return _text(value)
    if type_ is not ua.VariantType.String:
        return value
    if isinstance(value, Text):
        return _clean(value.text)
    return _clean(value if isinstance(value, str) else json_of(value))


def _clean(text: str) -> str:
    """Return a text that has UTF-8: half of a surrogate pair has none."""
    return text if text.isascii() else text.encode(errors='replace').decode()


_TYPES: Mapping[type, ua.VariantType] = {
    bool: ua.VariantType.Boolean,
    float: ua.VariantType.Double,
    Text: ua.VariantType.LocalizedText,
}


def _resource(type_: str, plain: Mapping[str, object]) -> Any:
    names = {field.name for field in dataclasses.fields(getattr(ua, type_))} - {'Encoding'}
    fields = {name: _resource_field(name, plain[name]) for name in names if name in plain}
    return _made(type_, **fields)


def _resource_field(name: str, plain: object) -> Any:
    if name == 'Description':
        return _texts(texts_from_plain(plain))
    if name == 'EngineeringUnits':
        return _unit(str(plain))
    if name in ('Properties', 'Subproperties'):
        several = plain if isinstance(plain, (list, tuple)) else []
        properties = (element for element in several if isinstance(element, Mapping))
        return [_resource('ISA95PropertyDataType', element) for element in properties]
    if name == 'Value':
        return _variant('', tuple(plain) if isinstance(plain, list) else plain)
    return _clean(str(plain))


def _unit(text: str) -> ua.EUInformation:
    unit = ua.EUInformation()
    unit.DisplayName = ua.LocalizedText(_clean(text))
    return unit


def _text(text: Text) -> ua.LocalizedText:
    return ua.LocalizedText(_clean(text.text), _clean(text.locale) or None)


def _texts(texts: Sequence[Text]) -> list[ua.LocalizedText] | None:
    return [_text(text) for text in texts] or None


def _time(seconds: float | None) -> datetime | None:
    return None if seconds is None else moment(seconds)
