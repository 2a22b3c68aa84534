"""The job order parameters that OPC 40001-3 (Machinery, Job Management) defines by name.

They are kept in `details` under their names, and told with the order and its response. No rule of
the cell reads them but RunsPlanned, the quantity, and ReasonForStateChange, a comment.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum

from bt_orchestrator.view.report.isa95.parts import (
    Parameter,
    Text,
    text_to_plain,
    texts_from_plain,
)

RUNS_PLANNED = 'RunsPlanned'
REASON = 'ReasonForStateChange'


class Kind(Enum):
    """The type of a named parameter."""

    TEXTS = 'localized texts'
    NAMES = 'texts'
    NUMBER = 'a number'
    """A finite one."""
    WHOLE = 'a whole number'
    """Of 32 bits."""
    YES_NO = 'a boolean'


KINDS: Mapping[str, Kind] = {
    'JobName': Kind.TEXTS,
    'OrderNumbers': Kind.NAMES,
    'Customers': Kind.NAMES,
    'CustomerOrderNumbers': Kind.NAMES,
    'JobExecutionMode': Kind.WHOLE,
    'PlannedProductionTime': Kind.NUMBER,
    'PlannedSetupTime': Kind.NUMBER,
    'PlannedTimePerRun': Kind.NUMBER,
    'PlannedQuantityPerRun': Kind.NUMBER,
    'PlannedOrderQuantity': Kind.NUMBER,
    'Overproduction': Kind.YES_NO,
    'PlannedDuration': Kind.NUMBER,
    'JobAnnotation': Kind.TEXTS,
}
"""Table 1 of OPC 40001-3 1.0.1, of those for a job order. Durations are milliseconds."""

IN_RESPONSE = ('JobName', 'OrderNumbers', 'Customers', 'CustomerOrderNumbers', 'JobExecutionMode')
"""Those that the table has for a job response too."""


def wrong_value(parameter: Parameter) -> str | None:
    """Say why a named parameter cannot have its value; None: it can."""
    kind = KINDS[parameter.id]
    if _fits(kind, parameter.value):
        return None
    return f'expected {kind.value}, found {parameter.value!r}'


def named_to_plain(parameter: Parameter) -> object:
    """Return the value of a named parameter as JSON, with its unit and its parts if it has any."""
    value = _value_to_plain(KINDS.get(parameter.id), parameter.value)
    if not (parameter.unit or parameter.parts or parameter.description):
        return value
    plain: dict[str, object] = {'Value': value}
    if parameter.description:
        plain['Description'] = [text_to_plain(text) for text in parameter.description]
    if parameter.unit:
        plain['EngineeringUnits'] = parameter.unit
    if parameter.parts:
        plain['Subparameters'] = {part.id: named_to_plain(part) for part in parameter.parts}
    return plain


def named_parameters(
    details: Mapping[str, object], names: Iterable[str] = KINDS
) -> Iterator[Parameter]:
    """Yield the named parameters that details have, in the order of the standard.

    What another door put under such a name, and is no value of its type, is left out.
    """
    for name in names:
        if name in details:
            parameter = named_from_plain(name, details[name])
            if wrong_value(parameter) is None:
                yield parameter


def named_from_plain(name: str, plain: object) -> Parameter:
    """Return the named parameter that JSON tells of."""
    kind = KINDS.get(name)
    if not isinstance(plain, Mapping) or 'Value' not in plain:
        return Parameter(name, _value_from_plain(kind, plain))
    parts = plain.get('Subparameters')
    inner = parts.items() if isinstance(parts, Mapping) else ()
    return Parameter(
        name,
        _value_from_plain(kind, plain['Value']),
        texts_from_plain(plain.get('Description')),
        str(plain.get('EngineeringUnits', '')),
        tuple(named_from_plain(str(key), value) for key, value in inner),
    )


def _fits(kind: Kind, value: object) -> bool:
    several = value if isinstance(value, tuple) else (value,)
    match kind:
        case Kind.TEXTS:
            return all(isinstance(member, (Text, str)) for member in several)
        case Kind.NAMES:
            return all(isinstance(member, str) for member in several)
        case Kind.NUMBER:
            return _is_finite(value)
        case Kind.WHOLE:
            return isinstance(value, int) and _is_finite(value) and abs(value) < 2**31
        case Kind.YES_NO:
            return isinstance(value, bool)


def _is_finite(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return abs(value) <= _LARGEST


_LARGEST = sys.float_info.max
"""Beyond it an integer is no Double."""


def _value_to_plain(kind: Kind | None, value: object) -> object:
    several = value if isinstance(value, tuple) else (value,)
    if kind is Kind.NAMES:
        return list(several)
    if kind is Kind.TEXTS:
        return [
            text_to_plain(member if isinstance(member, Text) else Text(str(member)))
            for member in several
        ]
    if isinstance(value, tuple):
        return [_value_to_plain(None, member) for member in value]
    return text_to_plain(value) if isinstance(value, Text) else value


def _value_from_plain(kind: Kind | None, plain: object) -> object:
    if kind is Kind.TEXTS:
        return texts_from_plain(plain)
    if kind is Kind.NAMES:
        several = plain if isinstance(plain, (list, tuple)) else [plain]
        return tuple(several)
    if kind is Kind.NUMBER and isinstance(plain, int):
        return float(plain)  # JSON does not tell 4.0 from 4
    if isinstance(plain, (list, tuple)):
        return tuple(_value_from_plain(None, member) for member in plain)
    return plain
