"""Frozen facts and events as plain data that JSON can carry, and back.

Fields that equal their default are left out, enums are their values, a text with references is
`{"$": [...]}`, and a float that JSON has no number for is `{"$float": "nan"}`, `inf` or `-inf`.
No name in a ROS 2 message begins with `$`. Records of events follow formats: events.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from enum import Enum
from functools import lru_cache, partial
from itertools import compress
from json.encoder import c_make_encoder, encode_basestring  # type: ignore[attr-defined]
from operator import itemgetter, ne
from typing import Any, NamedTuple, TypeVar, cast

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import Script, Task

_T = TypeVar('_T')
_TEMPLATE = '$'
_NOT_FINITE = '$float'
_APART = ('made_from', 'most_items', 'likely')
"""Keys outside of the digest: no goal depends on them."""

_OF_CELL = (*_APART, 'hold_after', 'first_piece')

_DIGEST = '$digest'
_TEXT = '$text'
_SCALARS: tuple[type, ...] = (str, int, bool, type(None))
"""Written unchanged; a float may have no JSON form."""
_ENCODER = json.JSONEncoder(ensure_ascii=False, allow_nan=False)
_encode_ascii = json.JSONEncoder(allow_nan=False).encode
_FIRST = ('seq', 'time', 'event', 'job', 'section', 'item', 'task')


def to_record(event: e.Event) -> dict[str, Any]:
    """Return the one record of an event that every output carries (formats: events)."""
    layout = _layout(cast(type, type(event)))
    values = layout.values_of(vars(event))
    differ = compress(zip(layout.names, values, strict=True), map(ne, values, layout.defaults))
    record: dict[str, Any] = {'seq': event.seq, 'time': event.time, 'event': event.event}
    record.update(differ)
    for name in layout.no_scalars & record.keys():
        record[name] = to_plain(record[name])
    return record


def to_text(event: e.Event) -> str:
    """Return the record of an event as one line of JSON, in a third of the time."""
    try:
        text = _text_maker(cast(type, type(event)))(event)
    except TypeError:  # a value has another class than its annotation
        return _json(to_record(event))
    return text if text.isascii() or _has_utf8(text) else _encode_ascii(to_record(event))


@lru_cache(maxsize=256)
def _text_maker(kind: type) -> Callable[[e.Event], str]:
    """Compile one f-string that is the text of the events of a class, as `dataclass` does it.

    Of each field it has what stands before the value, and the value unless that is the default.
    """
    layout, known = _layout(kind), {'string': encode_basestring, 'any': _text_of, 'no': ''}
    fields, event = [], cast('type[e.Event]', kind).event
    for number, (name, default) in enumerate(zip(layout.names, layout.defaults, strict=True)):
        known |= {f'before{number}': f', "{name}": ', f'default{number}': default}
        kinds = _kinds(hints_of(kind)[name]) if name in _as_it_is(kind) else {Any}
        is_text = kinds <= ({str, type(None)} if default is None else {str})
        text = f'before{number} + {"string" if is_text else "any"}(it.{name})'
        fields.append(f'{{no if it.{name} == default{number} else {text}}}')
    begin = f'{{{{"seq": {{it.seq}}, "time": {{any(it.time)}}, "event": "{event}"'
    make = eval(f"lambda it: f'{begin}{''.join(fields)}}}}}'", known)
    return cast('Callable[[e.Event], str]', make)


def _text_of(value: Any) -> str:
    kind = type(value)
    if kind is int or (kind is float and math.isfinite(value)):
        return repr(value)
    if kind in (Script, Cell):
        return text_of(value)
    return ''.join(_parts(to_plain(value), 0))


def json_of(value: Any) -> str:
    """Return any value as strict JSON, on one line, that can be written as UTF-8."""
    return _json(to_plain(value))


def _json(plain: Any) -> str:
    text = ''.join(_parts(plain, 0))
    # Half of a surrogate pair has no UTF-8; only then is all that is not ASCII escaped.
    return text if text.isascii() or _has_utf8(text) else _encode_ascii(plain)


def _parts_of(encoder: json.JSONEncoder) -> Callable[[Any, int], Iterable[str]]:
    """Return what makes the parts of a text; the encoder itself makes this anew for each text."""
    if c_make_encoder is None:  # an interpreter without the extension
        return lambda plain, _: encoder.iterencode(plain)
    made: Callable[[Any, int], Iterable[str]] = c_make_encoder(
        None,
        encoder.default,
        encode_basestring,
        None,
        encoder.key_separator,
        encoder.item_separator,
        encoder.sort_keys,
        encoder.skipkeys,
        encoder.allow_nan,
    )
    return made


_parts = _parts_of(_ENCODER)


def _has_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


class _Layout(NamedTuple):
    """The fields of an event in the order of its record, without number and time."""

    names: Sequence[str]
    defaults: Sequence[Any]
    values_of: Callable[[Mapping[str, Any]], Sequence[Any]]
    """Returns the values of an event by its names."""
    no_scalars: Set[str]
    """Fields that may have other values than text, integer, truth value or nothing."""


@lru_cache(maxsize=256)
def _layout(kind: type) -> _Layout:
    """Return the layout of the record of an event.

    Cached: every event is written, and inspecting its class each time took 30 us of 35.
    """
    fields = {field.name: _default(field) for field in dataclasses.fields(kind)}
    ordered = dict.fromkeys((*(name for name in _FIRST if name in fields), *fields))
    names = [name for name in ordered if name not in ('seq', 'time')]
    scalars = (name for name in _as_it_is(kind) if float not in _kinds(hints_of(kind)[name]))
    return _Layout(
        names,
        [fields[name] for name in names],
        _getter(names),
        set(names).difference(scalars),
    )


def _getter(names: Sequence[str]) -> Callable[[Mapping[str, Any]], Sequence[Any]]:
    if len(names) > 1:
        return itemgetter(*names)
    return lambda values: [values[name] for name in names]


def from_record(record: Mapping[str, Any]) -> e.Event:
    """Return the event that a record describes.

    :raises KeyError: there is no event of that name
    """
    fields = {key: value for key, value in record.items() if key != 'event'}
    return from_plain(event_types()[record['event']], fields)


def known_event(record: Mapping[str, Any]) -> e.Event | None:
    """Return the event that a record of an older or newer program describes, for a reader.

    Unknown fields are left out. None: the event is unknown, or a field is missing or invalid.
    """
    kind = event_types().get(record['event'])
    if kind is None:
        return None
    try:
        return from_plain(kind, {key: record[key] for key in _fields_in(record, kind)})
    except (AttributeError, KeyError, TypeError, ValueError):
        return None


def _fields_in(record: Mapping[str, Any], kind: type) -> set[str]:
    return record.keys() & (hints_of(kind).keys() - {'event'})


@lru_cache(maxsize=1)
def event_types() -> Mapping[str, type[e.Event]]:
    """Return every event class by its name in the record."""
    public = (getattr(e, name) for name in e.__all__)
    classes = (c for c in public if isinstance(c, type) and issubclass(c, e.Event))
    return {c.event: c for c in classes if hasattr(c, 'event')}


def text_of(definition: Script | Cell) -> str:
    """Return a script or a cell as JSON, on one line, that can be written as UTF-8.

    It is computed once: a script of 10,000 tasks takes a second, and is written more than once. It
    is included when a script is sent to another process.
    """
    known = vars(definition)
    if _TEXT not in known:
        known[_TEXT] = json_of(definition)
    return str(known[_TEXT])


def digest(definition: Script | Cell | Recipe) -> str:
    """Return a digest of a script, a cell or a recipe by what it says, wherever it comes from."""
    known = vars(definition)
    if _DIGEST not in known:  # as a cached property: its cost grows with the size
        plain = to_plain(definition)
        for name in _OF_CELL if isinstance(definition, Cell) else _APART:
            plain.pop(name, None)
        known[_DIGEST] = digest_of(plain)
    return str(known[_DIGEST])


def digest_of(plain: Any) -> str:
    """Return a digest of plain data."""
    text = json.dumps(plain, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def to_plain(value: Any, *, whole: bool = False) -> Any:
    """Return a value as dicts, lists and scalars.

    :param whole: with the fields that equal their default as well, for readers that do not know it
    """
    kind = type(value)
    if kind in _SCALARS:
        return value
    if kind is float:
        return value if math.isfinite(value) else {_NOT_FINITE: repr(value)}
    if isinstance(value, Template):
        parts = [p if isinstance(p, str) else to_plain(p, whole=whole) for p in value.parts]
        return {_TEMPLATE: parts}
    if dataclasses.is_dataclass(value):
        if whole:
            return plain_but(value)
        return {
            field.name: to_plain(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if not _is_default(field, getattr(value, field.name))
        }
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Mapping):
        return {_key(key): to_plain(member, whole=whole) for key, member in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(member, whole=whole) for member in value]
    return value


def plain_but(fact: Any, *without: str) -> dict[str, Any]:
    """Return a dataclass with all its fields as plain data, but for some."""
    return _whole(fact.__class__, without)(fact)


@lru_cache(maxsize=256)
def _whole(kind: type, without: tuple[str, ...]) -> Callable[[Any], dict[str, Any]]:
    """Compile what makes a dictionary of fields: a status is a hundred facts, every second."""
    made = [
        f'{field.name!r}: {_whole_value(hints_of(kind)[field.name], f"it.{field.name}")}'
        for field in dataclasses.fields(kind)
        if field.name not in without
    ]
    known = {'plain': partial(to_plain, whole=True), 'fact': plain_but, 'is_finite': math.isfinite}
    make = eval(f'lambda it: {{{", ".join(made)}}}', known)
    return cast('Callable[[Any], dict[str, Any]]', make)


def _whole_value(hint: Any, value: str) -> str:
    """Return the source text of what makes a value plain."""
    origin, kinds = typing.get_origin(hint), _kinds(hint)
    if origin is tuple and Ellipsis in kinds:
        member = _whole_value(typing.get_args(hint)[0], 'one')
        return f'list({value})' if member == 'one' else f'[{member} for one in {value}]'
    if origin is Mapping or not all(isinstance(kind, type) for kind in kinds):
        return f'plain({value})'
    if kinds <= set(_SCALARS):
        return value
    if kinds <= {float, type(None)}:
        return f'({value} if {value} is None or is_finite({value}) else plain({value}))'
    if origin is None and issubclass(hint, Enum):
        return f'{value}.value'
    is_fact = origin is None and dataclasses.is_dataclass(hint) and hint is not Template
    return f'fact({value})' if is_fact else f'plain({value})'


def _key(key: Any) -> str:
    return str(key.value if isinstance(key, Enum) else key)


def from_plain(kind: type[_T], value: Any) -> _T:
    """Return a value of an annotated type from plain data."""
    return cast('_T', _read(kind, value))


def _is_default(field: dataclasses.Field[Any], value: Any) -> bool:
    if field.default is not dataclasses.MISSING:
        # 1 equals True, and is another value.
        return bool(value == field.default) and (value is True) is (field.default is True)
    if field.default_factory is not dataclasses.MISSING:
        return not value
    return False


def _default(field: dataclasses.Field[Any]) -> Any:
    """Return the default of a field; one that is equal to nothing if it has none."""
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _read(kind: Any, value: Any) -> Any:
    if kind is object:
        return value  # opaque JSON: what looks like a template in it is none
    if kind is Any or value is None:
        return _read_free(value)
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return _read_dataclass(kind, value)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(value)
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        return _read(next(a for a in arguments if a is not type(None)), value)
    if origin is tuple:
        return tuple(_read(arguments[0], member) for member in value)
    if origin is Mapping:
        return {arguments[0](k): _read(arguments[1], v) for k, v in value.items()}
    return value


def _read_dataclass(kind: type, value: Any) -> Any:
    if kind is Template:
        return _read_free(value)
    hints, as_it_is = hints_of(kind), _as_it_is(kind)
    read = {k: v if k in as_it_is else _read(hints[k], v) for k, v in value.items()}
    for name in _of_task(kind) & read.keys():
        read[name] = {key: _read(hints_of(Task)[key], v) for key, v in value[name].items()}
    return kind(**read)


@lru_cache(maxsize=256)
def _of_task(kind: type) -> frozenset[str]:
    """Return the fields that hold values of fields of a task, by their names."""
    marked = (field.name for field in dataclasses.fields(kind) if 'of_task' in field.metadata)
    return frozenset(marked)


@lru_cache(maxsize=256)
def _as_it_is(kind: type) -> frozenset[str]:
    """Return the fields whose values JSON carries unchanged: most fields of most events."""
    plain = {str, int, float, bool, type(None)}
    return frozenset(
        name
        for name, hint in hints_of(kind).items()
        if _kinds(hint) <= plain
        and typing.get_origin(hint) in (None, types.UnionType, typing.Union)
    )


def _kinds(hint: Any) -> Set[Any]:
    return {*(typing.get_args(hint) or (hint,))}


def _read_free(value: Any) -> Any:
    """Read values without annotation: arguments, which may be or contain templates."""
    if isinstance(value, Mapping):
        if list(value) == [_TEMPLATE]:
            parts = value[_TEMPLATE]
            return Template(tuple(p if isinstance(p, str) else _read(Reference, p) for p in parts))
        if list(value) == [_NOT_FINITE]:
            return not_finite(value[_NOT_FINITE])
        return {key: _read_free(member) for key, member in value.items()}
    if isinstance(value, (list, tuple)):
        return [_read_free(member) for member in value]
    return value


def not_finite(name: str) -> float:
    """Return nan, inf or -inf by its name; nan is one object, to keep a state equal to its copy.

    :raises ValueError: it is none of them
    """
    value = float(name)
    return math.nan if math.isnan(value) else value


@lru_cache(maxsize=256)
def hints_of(kind: type) -> Mapping[str, Any]:
    """Return the annotations of a class as types."""
    return typing.get_type_hints(kind)
