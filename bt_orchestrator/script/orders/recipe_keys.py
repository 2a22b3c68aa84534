"""The keys of a recipe."""

from __future__ import annotations

from dataclasses import replace

from bt_orchestrator.model.limits import OPERATIONS
from bt_orchestrator.script.keys import Key, Kind, Table, whole
from bt_orchestrator.script.names import ID_FORM, NAME_WITHOUT_DOTS
from bt_orchestrator.script.script_keys import FIRST_PIECE, HOLD_AFTER, LOTS, PARAMS, REPEAT
from bt_orchestrator.script.task_keys import TASK

_OF_EQUIPMENT = ('task', 'action', 'args', 'requires_conveyor', 'qty_change', 'setup')
"""Keys of a task that are those of the component that does it."""

_SERIAL = "what the operation gives that is the item's serial, text or a whole number"

_OWN = (
    Key(
        'id',
        Kind.TEXT,
        'name of the operation, and of the task that it becomes',
        'insert',
        required=True,
        form=ID_FORM,
        rule='8.5',
    ),
    Key(
        'do',
        Kind.NAMES,
        'capability that does it, or a list: any of them will do, the first is preferred',
        '[glue, tape]',
        required=True,
        fewest=1,
        rule='8.5',
    ),
    Key(
        'after',
        Kind.NAMES,
        'operations that come directly before; absent: the one above',
        '[drill, deburr]',
        rule='8.5',
    ),
    Key(
        'parameters',
        Kind.MAPPING,
        'values for the parameters of the capability; references are allowed',
        '{text: "${params.label}"}',
        name_form=NAME_WITHOUT_DOTS,
        rule='8.5',
    ),
    Key(
        'needs',
        Kind.MAPPING,
        'operation that gives each thing that the capability needs',
        '{pose: locate}',
        members=Kind.TEXT,
        name_form=NAME_WITHOUT_DOTS,
        rule='8.5',
    ),
)

OPERATION = Table(
    'an operation',
    (
        *_OWN,
        *(
            replace(key, meaning=_SERIAL, example='code') if key.name == 'identifies' else key
            for key in TASK.keys
            if key.name not in (*_OF_EQUIPMENT, 'id')
        ),
    ),
    misplaced={
        **TASK.misplaced,
        **{
            key: (
                f'`{key}` is a matter of the equipment, which a recipe does not name',
                f'write `{key}` at the capability, in the cell file',
            )
            for key in _OF_EQUIPMENT
        },
    },
    rivals=TASK.rivals,
)

REWORK = Table(
    'a repeat of operations',
    (
        Key(
            'repeat',
            Kind.LIST,
            'operations, done in order, and all again where a verdict refuses a result of one',
            '[{id: glue, do: glue}, {id: inspect, do: measure, fails_unless: ...}]',
            required=True,
            of=(OPERATION,),
            fewest=1,
            rule='3.9',
        ),
        REPEAT.by_name['times'],
    ),
    misplaced=REPEAT.misplaced,
)

RECIPE = Table(
    'a recipe',
    (
        Key(
            'recipe',
            Kind.TEXT,
            'name of the recipe',
            'WM-100',
            required=True,
            form=ID_FORM,
            rule='8.5',
        ),
        replace(
            whole('version', 'a new number for each change', '1', 1, rule='8.5'), required=True
        ),
        Key(
            'script',
            Kind.TEXT,
            'name of the script that is generated from it',
            'my_process',
            required=True,
            form=ID_FORM,
            rule='8.5',
        ),
        PARAMS,
        LOTS,
        HOLD_AFTER,
        FIRST_PIECE,
        Key(
            'operations',
            Kind.LIST,
            f'how one item is made, {OPERATIONS} at most; each after the one above, unless '
            '`after` says otherwise',
            '[{id: pick, do: take_from_case}]',
            required=True,
            of=(OPERATION, REWORK),
            fewest=1,
            rule='8.5',
        ),
    ),
    misplaced={
        key: (
            f'`{key}` belongs to a script, which is generated from the recipe and the cell',
            f'remove `{key}`',
        )
        for key in ('sections', 'lateral_dependencies', 'zones', 'initialization')
    },
)

_NOT_TO_SET = (
    *('id', 'task', 'action', 'args', 'qty_change', 'when', 'unless', 'fails_unless'),
    *('identifies', 'likely', 'setup'),
)

CHANGE = Table(
    'a changed operation',
    tuple(key for key in TASK.keys if key.name not in _NOT_TO_SET),
    misplaced={
        **TASK.misplaced,
        **{
            key: (f'`{key}` cannot be overridden', 'change the recipe, or the cell file')
            for key in _NOT_TO_SET
        },
    },
    rivals=(('continue_if_fail', 'on_failure'),),
)

OVERRIDES = Table(
    'an overrides file',
    (
        Key(
            'bind',
            Kind.MAPPING,
            'component that does an operation',
            '{insert: component_3a}',
            members=Kind.TEXT,
            name_form=ID_FORM,
            rule='8.5',
        ),
        Key(
            'set',
            Kind.MAPPING,
            'keys of the task that an operation becomes',
            '{deburr: {timeout: 20.0}}',
            of=(CHANGE,),
            name_form=ID_FORM,
            rule='8.5',
        ),
        Key(
            'order',
            Kind.LIST,
            'lists of operations, each done in the order given',
            '[[drill, deburr]]',
            members=Kind.LIST,
            rule='8.5',
        ),
    ),
)
