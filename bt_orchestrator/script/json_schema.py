"""JSON Schema of the users' files, made from the tables of their keys, for editors.

Draft 7, which every editor's YAML support knows. A schema takes everything that the reader takes;
what it refuses is what can be known of one file alone, without types, cell and other keys.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.conditions.condition_keys import CONDITION
from bt_orchestrator.script.keys import Key, Kind, Table
from bt_orchestrator.script.names import NAME_WITHOUT_DOTS
from bt_orchestrator.script.orders.recipe_keys import OVERRIDES, RECIPE
from bt_orchestrator.script.references import OPEN
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_keys import ORDER, SCRIPT
from bt_orchestrator.script.shifts.shifts_keys import REASONS, SHIFTS
from bt_orchestrator.script.yaml_nodes import as_data

Schema = dict[str, Any]

DRAFT = 'http://json-schema.org/draft-07/schema#'

SCHEMA_FILES: Mapping[str, Table] = {
    'cell.schema.json': CELL,
    'script.schema.json': SCRIPT,
    'work_order.schema.json': ORDER,
    'recipe.schema.json': RECIPE,
    'overrides.schema.json': OVERRIDES,
    'shifts.schema.json': SHIFTS,
    'reasons.schema.json': REASONS,
}
"""The content of `schemas/`."""

_SCALARS = ['string', 'number', 'boolean']

_TEXTS = ['string', 'number']
"""A text may look like a number: ids are the text as written. The reader takes `true` as a text as
well, but an editor with such a schema offers true and false at every id."""


def json_schema(root: Table) -> Schema:
    """Return the schema of one kind of file; `root` is the table of its uppermost keys."""
    others = {table.name: table for table in root.tree() if table is not root}
    return {
        '$schema': DRAFT,
        'title': root.name[0].upper() + root.name[1:],
        **_table(root),
        'definitions': {_slug(table): _written(table) for table in others.values()},
    }


def _table(table: Table) -> Schema:
    schema: Schema = {
        'type': 'object',
        'properties': {key.name: _key(key) for key in table.keys},
        'additionalProperties': False,
    }
    required = [key.name for key in table.keys if key.required]
    if required:
        schema['required'] = required
    if table.rivals:
        schema['allOf'] = [{'not': {'required': list(pair)}} for pair in table.rivals]
    if table.one_of:
        schema['anyOf'] = [{'required': [name]} for name in table.one_of]
    if table.forms:
        schema['oneOf'] = [
            {'required': list(form), 'maxProperties': len(form)} for form in table.forms
        ]
    return schema


def _written(table: Table) -> Schema:
    """Return what may stand for a table's mapping: the mapping, or its one short form."""
    if not table.short:
        return _table(table)
    return {'anyOf': [_value(table.by_name[table.short]), _table(table)]}


def _key(key: Key) -> Schema:
    """Return a key's schema; draft 7 ignores what stands beside a $ref, so that is wrapped."""
    value = _value(key)
    schema = {'description': key.meaning, **({'allOf': [value]} if '$ref' in value else value)}
    if key.default is not None:
        schema['default'] = key.default
    return {**schema, 'examples': [_example(key)]}


def _value(key: Key) -> Schema:
    return _VALUES[key.kind](key)


def _text(key: Key) -> Schema:
    if not key.form:
        return {'type': _TEXTS, 'minLength': 1}
    types = _TEXTS if re.fullmatch(key.form, '1') else 'string'
    return {'type': types, 'pattern': f'^(?:{key.form})$'}


def _whole(key: Key) -> Schema:
    return {'type': 'integer', **_range(key)}


def _timeout(key: Key) -> Schema:
    return {'anyOf': [_seconds(key), {'const': 'none'}]}


def _seconds(key: Key) -> Schema:
    return {'type': 'number', **_range(key)}


def _sections(key: Key) -> Schema:
    many = {'type': 'array', 'items': _whole(key), 'minItems': 1, 'uniqueItems': True}
    return {'anyOf': [_whole(key), many]}


def _names(key: Key) -> Schema:
    name = {'type': _TEXTS, 'minLength': 1}
    return {'anyOf': [name, {'type': 'array', 'items': name, **_fewest('minItems', key)}]}


def _condition(key: Key) -> Schema:
    return {'anyOf': [_reference(key), _ref(CONDITION)]}


def _reference(_: Key) -> Schema:
    return {'type': 'string', 'pattern': re.escape(OPEN)}


def _bound(_: Key) -> Schema:
    parameter = f'^{re.escape(OPEN)}params\\.{NAME_WITHOUT_DOTS}\\}}$'
    return {'anyOf': [{'type': 'number'}, {'type': 'string', 'pattern': parameter}]}


def _list(key: Key) -> Schema:
    member = _member(key)
    if key.is_nested:
        member = {'anyOf': [member, {'type': 'array', 'items': member, 'minItems': 1}]}
    most = {} if key.most is None else {'maxItems': key.most}
    return {'type': 'array', 'items': member, **_fewest('minItems', key), **most}


def _mapping(key: Key) -> Schema:
    member = _member(key)
    schema: Schema = {'type': 'object', **_fewest('minProperties', key)}
    if not key.name_form:
        return {**schema, 'additionalProperties': member}
    names = {f'^(?:{key.name_form})$': member}
    return {**schema, 'patternProperties': names, 'additionalProperties': False}


def _member(key: Key) -> Schema:
    """Return the schema of what stands in a list, or behind the names of a mapping."""
    if key.of:
        choices = [_ref(table) for table in key.of]
        return choices[0] if len(choices) == 1 else {'anyOf': choices}
    return _MEMBERS[key.members](key)


def _fewest(word: str, key: Key) -> Schema:
    return {word: key.fewest} if key.fewest else {}


def _range(key: Key) -> Schema:
    low = 'exclusiveMinimum' if key.kind is Kind.TIMEOUT else 'minimum'
    limits = {low: key.minimum, 'maximum': key.maximum}
    return {name: limit for name, limit in limits.items() if limit is not None}


def _ref(table: Table) -> Schema:
    return {'$ref': f'#/definitions/{_slug(table)}'}


def _slug(table: Table) -> str:
    """Return a table's name without its article: initialization_task."""
    return '_'.join(table.name.split()[1:])


def _example(key: Key) -> Any:
    node = compose(key.example, Report(key.name))
    assert node is not None, key
    return as_data(node)


_ANYTHING: Schema = {'type': [*_SCALARS, 'array', 'object']}

_VALUES: Mapping[Kind, Callable[[Key], Schema]] = {
    Kind.TEXT: _text,
    Kind.WHOLE: _whole,
    Kind.SECONDS: _seconds,
    Kind.TIMEOUT: _timeout,
    Kind.SHARE: _seconds,
    Kind.SHARES: lambda key: _ref(key.of[0]),
    Kind.SWITCH: lambda _: {'type': 'boolean'},
    Kind.CHOICE: lambda key: {'enum': list(key.choices)},
    Kind.SECTIONS: _sections,
    Kind.NAMES: _names,
    Kind.VALUE: lambda _: {'type': _SCALARS},
    Kind.INSTANT: _text,
    Kind.REFERENCE: _reference,
    Kind.BOUND: _bound,
    Kind.CONDITION: _condition,
    Kind.TABLE: lambda key: _ref(key.of[0]),
    Kind.MAPPING: _mapping,
    Kind.LIST: _list,
}

_MEMBERS: Mapping[Kind | None, Callable[[Key], Schema]] = {
    None: lambda _: _ANYTHING,
    Kind.TEXT: lambda _: {'type': _TEXTS, 'minLength': 1},
    Kind.VALUE: lambda _: {'type': _SCALARS},
    Kind.WHOLE: _whole,
    Kind.SECONDS: _seconds,
    Kind.BOUND: _bound,
    Kind.CONDITION: _condition,
    Kind.JSON: lambda _: {},
    Kind.MAPPING: lambda _: {'type': 'object'},
    Kind.LIST: lambda _: {'type': 'array', 'items': {'type': _TEXTS}, 'minItems': 2},
}
