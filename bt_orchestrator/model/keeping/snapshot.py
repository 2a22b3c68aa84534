"""The state of the cell as plain data that JSON can carry, and back, exactly.

No field is named here: annotations say how a value is stored, so a new field of the state needs no
code. An unsupported annotation is a TypeError, not a loss. Mutable objects, and scripts because
they are large, are stored once in a list of objects and referred to by their place in it, so that
object identity is kept.

A field that a record lacks has its default. So a state that was written before the field existed
can still be read, as events can.
"""

from __future__ import annotations

import copy
import dataclasses
import json
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_plain, hints_of, text_of, to_plain
from bt_orchestrator.model.jobs.initialization import Preparation
from bt_orchestrator.model.judging.used_ids import UsedIds
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.state.live_jobs import LiveJobs
from bt_orchestrator.model.stop_reason import STOP_AFTER

SCALARS = (str, int, float, bool)


def kept_fields() -> tuple[str, ...]:
    """Return the names of the fields of the state that a record has."""
    every = dataclasses.fields(CellState)
    return tuple(field.name for field in every if not field.metadata.get('derived'))


def state_to_plain(state: CellState) -> dict[str, Any]:
    """Return a state as dicts, lists and scalars.

    :raises TypeError: it has a field whose annotation cannot be kept
    """
    writer = Writer()
    fields = writer.fields_of(state)
    objects = [
        to_plain(instance) if isinstance(instance, Script) else instance
        for instance in writer.objects
    ]
    return {'state': fields, 'objects': objects}


def state_to_text(state: CellState) -> str:
    """Return the same as JSON; the stored text of scripts is reused."""
    writer = Writer()
    return text_of_state(writer.fields_of(state), [text_of_objects(writer.objects)])


def text_of_state(
    fields: Mapping[str, Any], pieces: Iterable[str], cell: Cell | None = None
) -> str:
    """Return a state as JSON.

    :param pieces: its objects, as `text_of_objects` writes them
    :param cell: for a reader who has not got its file; None: he has
    """
    objects = ', '.join(piece for piece in pieces if piece)
    defined = '' if cell is None else f'"cell": {text_of(cell)}, '
    return f'{{{defined}"objects": [{objects}], "state": {json.dumps(fields)}}}'


def text_of_objects(objects: Iterable[Any]) -> str:
    """Return objects of a `Writer` as JSON, without the brackets of a list."""
    return ', '.join(
        text_of(instance) if isinstance(instance, Script) else json.dumps(instance)
        for instance in objects
    )


def nearest(state: CellState, *, with_ids: bool = False) -> CellState:
    """Return what a virtual run has to know: of a long queue the first jobs, no past.

    :param with_ids: and which order ids were used; of sealed parts only the names
    """
    near = copy.copy(state)
    near.jobs = LiveJobs(state.jobs.first(QUEUE_SHOWN))
    used = {job.digest for job in near.jobs.values()}
    near.scripts = {name: script for name, script in state.scripts.items() if name in used}
    near.ended, near.order_ids, near.serials = {}, UsedIds(), UsedIds()
    if with_ids:
        near.order_ids = UsedIds(
            state.order_ids.others, state.order_ids.runs, list(state.order_ids.sealed)
        )
    else:
        near.released_scripts = {}
        for name in near.jobs:
            near.order_ids.add(name)
    return near


_NOTHING: Mapping[int, Any] = MappingProxyType({})


def state_from_plain(
    cell: Cell, plain: Mapping[str, Any], known: Mapping[int, Any] = _NOTHING
) -> CellState:
    """Return the state of a cell from a record.

    :param known: objects by their places that exist already
    :raises KeyError: it names something that the cell does not have
    :raises TypeError: it is damaged, or written by a newer version
    :raises ValueError: the same
    """
    state = CellState(cell)
    reader, hints, kept = Reader(plain['objects'], known), hints_of(CellState), kept_fields()
    for name, value in _of_today(plain['state']).items():
        if name not in kept:
            raise TypeError(f'the state has no field {name}')
        setattr(state, name, reader.read(hints[name], value))
    _fit(state)
    state.preparations = {d: Preparation(script, cell) for d, script in state.scripts.items()}
    return state


def _of_today(fields: Mapping[str, Any]) -> Mapping[str, Any]:
    """Convert the fields of an older version to the current form.

    `order_arrived` was false from an operator's stop to the next order, or start.
    """
    done = fields.get('done_once')
    if isinstance(done, list):  # action, constant and arguments in one text
        parts = (text.split(' ', 2) for text in done)
        fields = {
            **fields,
            'done_once': {f'{action} {name}': args for action, name, args in parts},
        }
    fields = {_RENAMED.get(name, name): value for name, value in fields.items()}
    if 'order_arrived' not in fields:
        return fields
    arrived, packml = fields['order_arrived'], PackmlState(fields['packml'])
    stands = not arrived and packml in _STANDS
    wish = {'command': VERBS[Cause.ABORT if packml in _ABORTED else Cause.STOP]}
    after = fields.get('stop_after')
    return {name: value for name, value in fields.items() if name != 'order_arrived'} | {
        'had_work': arrived,
        'stopped_by': wish if stands else None,
        'stop_after_by': {'command': STOP_AFTER + after} if after else None,
    }


_RENAMED = {'mode': 'packml', 'mode_since': 'packml_since', 'mode_times': 'packml_times'}
_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED, PackmlState.CLEARING)
_STANDS = (
    PackmlState.STOPPING,
    PackmlState.STOPPED,
    PackmlState.RESETTING,
    PackmlState.IDLE,
    *_ABORTED,
)


def _fit(state: CellState) -> None:
    """Fit a state to its cell, whose file may have changed since.

    :raises KeyError: an item or a cycle is where the cell has no section any more
    """
    fresh = CellState(state.cell)
    for number, section in state.sections.items():
        if number not in fresh.sections and (section.slot or section.cycle):
            raise KeyError(f'section {number}')
    state.sections = {n: state.sections.get(n, section) for n, section in fresh.sections.items()}
    state.readings = {n: state.readings.get(n, reading) for n, reading in fresh.readings.items()}


class Writer:
    """Makes plain data, and one list of the objects in it; scripts stand there unchanged."""

    def __init__(self) -> None:
        self.objects: list[Any] = []
        self._places: dict[int, int] = {}

    def fields_of(self, state: CellState) -> dict[str, Any]:
        """Return the fields of a state."""
        hints = hints_of(CellState)
        return {name: self.write(hints[name], getattr(state, name)) for name in kept_fields()}

    def write(self, kind: Any, value: Any) -> Any:
        """Return plain data of a value with an annotation."""
        return None if value is None else _how(kind)(self, value)

    def write_fields(self, kind: type, value: Any) -> dict[str, Any]:
        """Return the fields that have other values than their defaults."""
        known = vars(value)
        return {
            name: self.write(hint, known[name])
            for name, hint, default in _of_fields(kind)
            if known[name] is not default and known[name] != default
        }

    def place_of(self, kind: type, value: Any) -> int:
        """Return the place of an object in the list; it gets one when it has none."""
        if id(value) not in self._places:
            self._places[id(value)] = place = len(self.objects)
            self.objects.append(None)  # its place; what it names may come after it
            self.objects[place] = value if kind is Script else self.write_fields(kind, value)
        return self._places[id(value)]


@lru_cache(maxsize=256)
def _how(kind: Any) -> Callable[[Writer, Any], Any]:
    """Return the writer of an annotation's values; cached for queues of thousands of jobs."""
    if kind is Any:
        return lambda _, value: to_plain(value)
    if isinstance(kind, type):
        return _how_class(kind)
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        return _how(_without_none(kind))
    if origin in (dict, Mapping):
        return _how_mapping(arguments[0], arguments[1])
    member = _member(kind)
    if member in SCALARS:
        return lambda _, value: _in_order(origin, list(value))
    return lambda writer, value: [
        writer.write(member, element) for element in _in_order(origin, value)
    ]


def _how_class(kind: type) -> Callable[[Writer, Any], Any]:
    if _by_place(kind):
        return lambda writer, value: writer.place_of(kind, value)
    if dataclasses.is_dataclass(kind):
        return lambda writer, value: writer.write_fields(kind, value)
    if kind is LiveJobs:
        return _how_mapping(str, JobState)
    if issubclass(kind, tuple):
        return lambda writer, value: [
            writer.write(hint, member) for hint, member in zip(_of_tuple(kind), value, strict=True)
        ]
    if issubclass(kind, Enum):
        return lambda _, value: value.value
    if kind in SCALARS or kind is object:  # opaque JSON
        return lambda _, value: value
    raise TypeError(f'no way to keep a {kind.__name__}')


def _how_mapping(key: Any, member: Any) -> Callable[[Writer, Any], Any]:
    if key is str:
        return lambda writer, value: {
            name: writer.write(member, element) for name, element in value.items()
        }
    return lambda writer, value: [
        [writer.write(key, k), writer.write(member, element)] for k, element in value.items()
    ]


class Reader:
    """Makes values from plain data."""

    def __init__(self, objects: list[Any], known: Mapping[int, Any] = _NOTHING) -> None:
        """Begin.

        :param known: objects by their places that exist already
        """
        self._plain = objects
        self._objects = dict(known)

    def add(self, objects: Iterable[Any]) -> None:
        """Take in further objects."""
        self._plain.extend(objects)

    def read(self, kind: Any, value: Any) -> Any:
        """Return the value of an annotation that plain data tells of."""
        if value is None:
            return None
        if kind is Any:
            return from_plain(Any, value)
        if isinstance(kind, type):
            return self._read_class(kind, value)
        origin, arguments = typing.get_origin(kind), typing.get_args(kind)
        if origin in (types.UnionType, typing.Union):
            return self.read(_without_none(kind), value)
        if origin in (dict, Mapping):
            return self._read_mapping(arguments[0], arguments[1], value)
        return origin(self.read(_member(kind), member) for member in value)

    def _read_class(self, kind: type, value: Any) -> Any:
        if _by_place(kind):
            return self._object(kind, value)
        if dataclasses.is_dataclass(kind):
            return self._read_fields(kind, value)
        if kind is LiveJobs:
            return LiveJobs(self._read_mapping(str, JobState, value).values())
        if issubclass(kind, tuple):
            members = zip(_of_tuple(kind), value, strict=True)
            return kind(*(self.read(hint, member) for hint, member in members))
        return kind(value) if issubclass(kind, Enum) else value

    def _read_mapping(self, key: Any, member: Any, value: Any) -> dict[Any, Any]:
        pairs = value.items() if key is str else value
        return {self.read(key, k): self.read(member, element) for k, element in pairs}

    def _read_fields(self, kind: type, value: Mapping[str, Any]) -> Any:
        hints = hints_of(kind)
        return kind(
            **{name: self.read(hints[name], field_value) for name, field_value in value.items()}
        )

    def _object(self, kind: type, place: int) -> Any:
        if place not in self._objects:
            plain = self._plain[place]
            is_script = kind is Script
            instance = from_plain(kind, plain) if is_script else self._read_fields(kind, plain)
            self._objects[place] = instance
        return self._objects[place]


@lru_cache(maxsize=256)
def _by_place(kind: type) -> bool:
    """Tell whether a class has one place in the list of objects."""
    if kind is Script:
        return True
    return dataclasses.is_dataclass(kind) and not kind.__dataclass_params__.frozen  # type: ignore[attr-defined]


@lru_cache(maxsize=256)
def _of_fields(kind: type) -> tuple[tuple[str, Any, Any], ...]:
    """Return name, annotation and default of each field."""
    hints, fields = hints_of(kind), dataclasses.fields(kind)
    return tuple((field.name, hints[field.name], _default(field)) for field in fields)


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default  # MISSING, which equals nothing else


@lru_cache(maxsize=256)
def _of_tuple(kind: type) -> tuple[Any, ...]:
    """Return the annotations of a NamedTuple."""
    return tuple(hints_of(kind).values())


def _without_none(union: Any) -> Any:
    kinds = [kind for kind in typing.get_args(union) if kind is not type(None)]
    if len(kinds) != 1:
        raise TypeError(f'no way to keep {union}: it is not one kind or None')
    return kinds[0]


def _member(kind: Any) -> Any:
    """Return what a list, a set or a tuple of any length holds."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (list, set) or (origin is tuple and arguments[1:] == (...,)):
        return arguments[0]
    raise TypeError(f'no way to keep {kind}')


def _in_order(origin: Any, value: Any) -> Any:
    return sorted(value) if origin is set else value
