"""The keys of a cell file from which scripts are generated."""

from __future__ import annotations

from dataclasses import replace

from bt_orchestrator.script.keys import LARGEST_WHOLE, Key, Kind, Table
from bt_orchestrator.script.names import ID_FORM, NAME_WITHOUT_DOTS
from bt_orchestrator.script.task_keys import INITIALIZATION_TASK, TASK

_NO_ACTION = ('the component says which action it serves', 'remove `action`')

_CONDITIONS = ('when', 'unless', 'fails_unless', 'likely')

_MADE_BY_OTHERS = ('id', 'action', *_CONDITIONS)
"""Keys of a task that are those of the component, or of the operation that uses the capability."""


def _fields(name: str, meaning: str, example: str) -> Key:
    return Key(
        name,
        Kind.MAPPING,
        meaning,
        example,
        members=Kind.TEXT,
        name_form=NAME_WITHOUT_DOTS,
        rule='8.5',
    )


_OWN = (
    _fields('parameters', 'goal fields that an operation sets', '{text: special_argument_1}'),
    _fields('gives', 'result fields that later operations may use', '{label_ok: item_present}'),
    _fields(
        'needs',
        'goal fields that take what an earlier operation gives; none: the component asks the '
        'device that holds it',
        '{pose: special_argument_1}',
    ),
    Key(
        'holds',
        Kind.MAPPING,
        'what the device itself keeps for later operations, and for how many items',
        '{depth: 1}',
        minimum=1,
        maximum=LARGEST_WHOLE,
        members=Kind.WHOLE,
        name_form=NAME_WITHOUT_DOTS,
        rule='8.5',
    ),
)

CAPABILITY = Table(
    'a capability',
    (*(key for key in TASK.keys if key.name not in _MADE_BY_OTHERS), *_OWN),
    misplaced={
        **TASK.misplaced,
        'id': ('the task is named by the operation of a recipe', 'remove `id`'),
        'action': _NO_ACTION,
        **{
            key: (
                f'a capability has no `{key}`: only a recipe knows the other operations',
                f'write `{key}` at the operation',
            )
            for key in _CONDITIONS
        },
    },
    rivals=(('continue_if_fail', 'on_failure'),),
)

PREPARATION = Table(
    'a preparation',
    (
        *(
            replace(key, required=True, meaning='name of the task', example='ready_arm')
            if key.name == 'id'
            else key
            for key in INITIALIZATION_TASK.keys
            if key.name != 'action'
        ),
        Key(
            'after',
            Kind.NAMES,
            'components, or the conveyor, that are prepared before',
            'conveyor',
            rule='8.5',
        ),
    ),
    misplaced={**INITIALIZATION_TASK.misplaced, 'action': _NO_ACTION},
    rivals=INITIALIZATION_TASK.rivals,
)

CAPABILITIES = Key(
    'capabilities',
    Kind.MAPPING,
    'what recipes may ask of it, by name',
    '{drill: {task: TASK_A}}',
    of=(CAPABILITY,),
    name_form=ID_FORM,
    rule='8.5',
)

CHANGE = Table(
    'a change',
    (
        Key(
            'task',
            Kind.TEXT,
            'task constant of the change; a label where the type has no task field',
            'CHANGE_GRIPPER',
            required=True,
            rule='5.3',
        ),
        Key(
            'argument',
            Kind.TEXT,
            'goal field that takes the wanted value; absent: the one named as the setup',
            'special_argument_1',
            rule='5.3',
        ),
        Key(
            'reads',
            Kind.TEXT,
            'field of the state topic that tells the value, or a path to it; absent: none does',
            'gripper',
            rule='5.3',
        ),
    ),
    short='task',
)

SETUPS = Key(
    'setups',
    Kind.MAPPING,
    'what tasks need in one of several ways, with its values: a gripper, a program, a fixture',
    '{gripper: [small, large]}',
    members=Kind.LIST,
    name_form=NAME_WITHOUT_DOTS,
    rule='5.3',
)

CHANGES = Key(
    'changes',
    Kind.MAPPING,
    'task that changes each setup',
    '{gripper: {task: CHANGE_GRIPPER, argument: special_argument_1}}',
    of=(CHANGE,),
    name_form=NAME_WITHOUT_DOTS,
    rule='5.3',
)

WORKSPACES = Key(
    'workspaces',
    Kind.LIST,
    'spaces in which it works, for generated scripts: only tasks in different ones run side by '
    'side; absent: that of its section',
    '[left]',
    members=Kind.TEXT,
    fewest=1,
    rule='8.5',
)

PREPARE = Key(
    'prepare',
    Kind.TABLE,
    'its initialization in generated scripts',
    '{id: ready_arm, task: PREPARE}',
    of=(PREPARATION,),
    rule='8.5',
)
