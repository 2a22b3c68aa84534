"""Facts as messages and back, compiled from the annotations of a fact and the types of a message.

A fact's field stands in the message field of its name. For None, a message has an empty text, an
empty message, an empty list, 0, the time 0 or -1 second. A mapping is a list of pairs, or else
JSON. A field that stands elsewhere has a codec. A field without a counterpart ends the import.
"""

from __future__ import annotations

import dataclasses
import json
import typing
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Any, Generic, NamedTuple, TypeVar

from bt_orchestrator.model.codec import hints_of, json_of
from bt_orchestrator.ros.clock import from_moment, from_time, to_moment, to_time
from bt_orchestrator.ros.types.interface_classes import message_class

_Fact = TypeVar('_Fact')

UNKNOWN_S = -1.0
_TIME = 'builtin_interfaces/Time'
_SCALARS: Mapping[Any, tuple[str, ...]] = {
    str: ('string',),
    bool: ('boolean',),
    int: ('uint16', 'uint32', 'uint64', 'int16'),
    float: ('double',),
}


class Codec(NamedTuple):
    """How a field stands in a message, if not in the message field of its name."""

    fields: tuple[str, ...]
    """Of the message; empty: the message does not tell it."""
    write: Callable[[Any], Mapping[str, Any]]
    """Return the values of these fields."""
    read: Callable[[Any], Any]
    """Return the value of the fact's field from the message."""


Apart = Mapping[str, Codec | str]
"""Codecs of fields, or other names in the message."""


class Mapped(NamedTuple, Generic[_Fact]):
    """A fact and its message."""

    write: Callable[[_Fact], Any]
    read: Callable[[Any], _Fact]
    message: Callable[[], Any]
    told_by: str
    """The message field that is empty where there is no such fact; empty: there always is one."""


class _Form(NamedTuple):
    """A value as source text: how it is written, and read."""

    write: Callable[[str], str]
    read: Callable[[str], str]


_SAME = _Form(str, str)
_KNOWN: dict[type, Mapped[Any]] = {}
"""Facts that have a message of their own."""
MAPPED: set[Any] = set()
"""Messages that are written or read by a mapping."""


def mapped(kind: type[_Fact], message: Any, apart: Apart | None = None) -> Mapped[_Fact]:
    """Compile the mapping of a fact; facts inside of it must have theirs.

    :raises TypeError: a field has no counterpart, or one of another type
    """
    made, used = _compiled(kind, message, kind, message, apart or {})
    untold = message.get_fields_and_field_types().keys() - used
    if untold:
        raise TypeError(f'{kind.__name__} has no field for {", ".join(sorted(untold))}')
    _KNOWN[kind] = made
    return made


def flat(
    kind: type, message: Any, apart: Apart, told_by: str = '', any_of: tuple[str, ...] = ()
) -> Codec:
    """Return the codec of a fact whose fields stand among the fields of an outer one.

    :param told_by: truth value of the message that says whether there is such a fact
    :param any_of: fields of which one tells that there is one
    """
    made, used = _compiled(kind, dict, kind, message, apart)
    flag, names = ({told_by: True} if told_by else {}), any_of or (told_by or made.told_by,)

    def write(fact: Any) -> Mapping[str, Any]:
        return {} if fact is None else {**made.write(fact), **flag}

    def read(message: Any) -> Any:
        is_told = any(not name or getattr(message, name) for name in names)
        return made.read(message) if is_told else None

    return Codec((*used, *flag), write, read)


def supplement(kind: type, message: Any, apart: Apart) -> Mapped[Any]:
    """Compile a message about some fields of a fact; it is read as these fields by name."""
    names = {
        field: name
        for name, codec in apart.items()
        for field in (codec.fields if isinstance(codec, Codec) else (codec,))
    }
    fields = [names.get(name, name) for name in message.get_fields_and_field_types()]
    return _compiled(kind, message, dict, message, apart, fields)[0]


def _compiled(
    kind: Any, writes: Any, reads: Any, message: Any, apart: Apart, fields: Any = None
) -> tuple[Mapped[Any], set[str]]:
    MAPPED.add(message)
    types, hints = message.get_fields_and_field_types(), hints_of(kind)
    scope: dict[str, Any] = {'writes': writes, 'reads': reads, **_HELPERS}
    written, read, used = [], [], set()
    for name in fields or hints:
        codec = apart.get(name, name)
        if isinstance(codec, Codec):
            scope[f'write_{name}'], scope[f'read_{name}'] = codec.write, codec.read
            written += [f'**write_{name}(it.{name})'] if codec.fields else []
            read.append(f'{name}=read_{name}(it)')
            used |= {*codec.fields}
        elif codec in types:
            form = _form(hints[name], types[codec], scope)
            written.append(f'{codec}={form.write(f"it.{name}")}')
            read.append(f'{name}={form.read(f"it.{codec}")}')
            used.add(codec)
        else:
            raise TypeError(f'{kind.__name__}.{name} has no field in {message.__name__}')
    source = f'write = lambda it: writes({", ".join(written)})\n'
    exec(f'{source}read = lambda it: reads({", ".join(read)})', scope)
    return Mapped(scope['write'], scope['read'], message, _told_by(kind, apart)), used


def _told_by(kind: Any, apart: Apart) -> str:
    """Return the message field of the first text or word that a fact must have."""
    for field in dataclasses.fields(kind):
        if field.default is field.default_factory and hints_of(kind)[field.name] is not float:
            return str(apart.get(field.name, field.name))
    return ''


_HELPERS = {
    'to_time': to_time,
    'from_time': from_time,
    'to_moment': to_moment,
    'from_moment': from_moment,
    'json_of': json_of,
    'loads': json.loads,
}


def _form(hint: Any, ros: str, scope: dict[str, Any]) -> _Form:
    """Return how a value of an annotated type stands in a message field of some type."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if type(None) in arguments:
        hint = next(argument for argument in arguments if argument is not type(None))
        stands = _optional if _member(ros) == ros else _at_most_one
        return stands(hint, ros, scope)
    if origin in {tuple, list}:
        element = _form(arguments[0], _member(ros), scope)
        if element is _SAME:
            return _Form(str, 'tuple({})'.format)
        return _Form(
            lambda it: f'[{element.write("one")} for one in {it}]',
            lambda it: f'tuple([{element.read("one")} for one in {it}])',
        )
    if origin in {Mapping, dict}:
        return _mapping(arguments, ros, scope)
    if hint is float and ros == _TIME:
        return _Form('to_time({})'.format, 'from_time({})'.format)
    if hint in _SCALARS:
        return _scalar(hint, ros)
    name = hint.__name__
    if issubclass(hint, Enum):
        scope[name] = hint
        _scalar(str, ros)
        return _Form('{}.value'.format, f'{name}({{}})'.format)
    scope[f'{name}_message'], scope[f'{name}_of'] = _KNOWN[hint].write, _KNOWN[hint].read
    return _Form(f'{name}_message({{}})'.format, f'{name}_of({{}})'.format)


def _optional(hint: Any, ros: str, scope: dict[str, Any]) -> _Form:
    if hint is float and ros == _TIME:
        return _Form('to_moment({})'.format, 'from_moment({})'.format)
    form = _form(hint, ros, scope)
    if hint is float:
        none, condition = repr(UNKNOWN_S), '{} >= 0.0'
    elif hint in _KNOWN:
        scope[f'no_{hint.__name__}'] = _KNOWN[hint].message
        none, condition = f'no_{hint.__name__}()', f'{{}}.{_KNOWN[hint].told_by}'
    else:
        none, condition = repr(hint() if hint in _SCALARS else ''), '{}'
    return _Form(
        lambda it: f'{none} if {it} is None else {form.write(it)}',
        lambda it: f'{form.read(it)} if {condition.format(it)} else None',
    )


def _at_most_one(hint: Any, ros: str, scope: dict[str, Any]) -> _Form:
    form = _form(hint, _member(ros), scope)
    return _Form(
        lambda it: f'[] if {it} is None else [{form.write(it)}]',
        lambda it: f'{form.read(f"{it}[0]")} if {it} else None',
    )


def _mapping(kinds: tuple[Any, ...], ros: str, scope: dict[str, Any]) -> _Form:
    if ros == 'string':
        return _Form('json_of({})'.format, 'loads({})'.format)
    pair = message_class(_member(ros).replace('/', '/msg/'))
    name, types = pair.__name__, pair.get_fields_and_field_types()
    scope[name] = pair
    MAPPED.add(pair)
    (first, second), types = types, tuple(types.values())
    key, value = (_form(kind, type_, scope) for kind, type_ in zip(kinds, types, strict=True))
    made = f'{name}({first}={key.write("key")}, {second}={value.write("value")})'
    read = f'{key.read(f"one.{first}")}: {value.read(f"one.{second}")}'
    return _Form(
        lambda it: f'[{made} for key, value in {it}.items()]',
        lambda it: f'{{{read} for one in {it}}}',
    )


def _scalar(kind: Any, ros: str) -> _Form:
    if ros not in _SCALARS[kind]:
        raise TypeError(f'{ros} holds no {kind.__name__}')
    return _SAME


def _member(ros: str) -> str:
    return ros.removeprefix('sequence<').removesuffix('>').removesuffix(', 1')
