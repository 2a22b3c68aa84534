"""The keys of a cell file."""

from __future__ import annotations

from dataclasses import replace

from bt_orchestrator.model.cell import (
    DEFAULT_DURATION_S,
    DEFAULT_TIMEOUT_S,
    MOST_ITEMS,
    WITHIN_S,
    Approval,
    OnFailure,
    Release,
    Start,
)
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S
from bt_orchestrator.script.capabilities.capability_keys import (
    CAPABILITIES,
    CHANGES,
    PREPARE,
    SETUPS,
    WORKSPACES,
)
from bt_orchestrator.script.keys import (
    LONGEST_SECONDS,
    Key,
    Kind,
    Table,
    action,
    action_type,
    whole,
    words,
)
from bt_orchestrator.script.names import NAME_WITHOUT_DOTS
from bt_orchestrator.script.ros_names import MESSAGE_TYPE_FORM, NAME_FORM, TOKEN_FORM
from bt_orchestrator.script.script_keys import HOLD_AFTER

MOST_SECTIONS = 1000

STATE = Table(
    'a state topic',
    (
        Key(
            'topic',
            Kind.TEXT,
            'ROS 2 topic name',
            '/unpacking/state',
            required=True,
            form=NAME_FORM,
            rule='2.5',
        ),
        Key(
            'type',
            Kind.TEXT,
            'message type',
            'std_msgs/msg/String',
            required=True,
            form=MESSAGE_TYPE_FORM,
            rule='2.5',
        ),
        Key(
            'field',
            Kind.TEXT,
            'field that is compared, or a path to it',
            'data',
            required=True,
            rule='2.5',
        ),
        Key(
            'ready',
            Kind.LIST,
            'values that allow a goal',
            '[READY]',
            required=True,
            members=Kind.VALUE,
            fewest=1,
            rule='2.5',
        ),
    ),
)

SAFETY = Table(
    'a safety input',
    (
        *(replace(key, rule='7.9') for key in STATE.keys),
        Key(
            'within',
            Kind.SECONDS,
            'longest time between two messages; goals end when it has passed',
            '0.5',
            default=WITHIN_S,
            minimum=0.05,
            maximum=10.0,
            rule='7.9',
        ),
    ),
)

_STATE = Key(
    'state',
    Kind.TABLE,
    'topic that says whether a goal may be sent; without it always',
    '{topic: /unpacking/state, type: std_msgs/msg/String, field: data, ready: [READY]}',
    of=(STATE,),
    rule='2.5',
)
_TIMEOUT = Key(
    'timeout',
    Kind.TIMEOUT,
    'seconds a task may take, from sending; none: no limit',
    '60.0',
    default=DEFAULT_TIMEOUT_S,
    minimum=0,
    maximum=LONGEST_SECONDS,
    rule='2.4',
)
_RESULT_TIMEOUT = Key(
    'result_timeout',
    Kind.SECONDS,
    'seconds for which its server remembers a goal that ended; what a crash leaves unknown is '
    'sent again only within that time',
    '10.0',
    default=RESULT_TIMEOUT_S,
    minimum=0,
    maximum=LONGEST_SECONDS,
    rule='9.2',
)
_RESULTS = Key(
    'results',
    Kind.MAPPING,
    'result fields of each task, for simulation; else true, 0 and empty; `{n}` in a text is the '
    'number of the goal',
    '{TASK_A: {measurement: 1.5}}',
    members=Kind.MAPPING,
    rule='8.3',
)
_FAULTS = Key(
    'faults',
    Kind.LIST,
    'faults of the simulated controller, each `[TASK][#NTH]=KIND[:SECONDS]` as for `sim-cell`',
    '["TASK_A#2=abort"]',
    members=Kind.TEXT,
    rule='8.3',
)

COMPONENT = Table(
    'a component',
    (
        Key(
            'section',
            Kind.SECTIONS,
            'section it belongs to, or a list of them; absent: none',
            '2',
            minimum=1,
            rule='5',
        ),
        action(),
        action_type(),
        _STATE,
        _TIMEOUT,
        _RESULT_TIMEOUT,
        Key(
            'durations',
            Kind.MAPPING,
            'nominal seconds of each task, for simulation and prediction; else 1.0',
            '{PREPARE: 1.0}',
            minimum=0,
            maximum=LONGEST_SECONDS,
            members=Kind.SECONDS,
            rule='8.3',
        ),
        _RESULTS,
        _FAULTS,
        CAPABILITIES,
        WORKSPACES,
        PREPARE,
        SETUPS,
        CHANGES,
    ),
    misplaced={
        'duration': (
            'a component has a nominal duration for each task',
            'write for instance `durations: {TASK_A: 1.0}`',
        ),
    },
)

CONVEYOR = Table(
    'the conveyor',
    (
        Key(
            'sections',
            Kind.WHOLE,
            'positions of the belt, numbered from 1 in the direction of travel',
            '5',
            required=True,
            minimum=1,
            maximum=MOST_SECTIONS,
            rule='3.5',
        ),
        action(),
        action_type(),
        Key(
            'task',
            Kind.TEXT,
            'task constant of one index move; only types with a task field need it',
            'MOVE_ONE_INDEX',
            rule='3.5',
        ),
        _STATE,
        _TIMEOUT,
        _RESULT_TIMEOUT,
        Key(
            'duration',
            Kind.SECONDS,
            'nominal seconds of every conveyor task, for simulation and prediction',
            '2.0',
            default=DEFAULT_DURATION_S,
            minimum=0,
            maximum=LONGEST_SECONDS,
            rule='8.3',
        ),
        whole(
            'retries', 'further attempts after a failed index move', '1', 0, default=0, rule='3.5'
        ),
        Key(
            'on_failure',
            Kind.CHOICE,
            'what a failed index move does',
            'hold',
            default=OnFailure.HOLD.value,
            choices=words(OnFailure, OnFailure.CONTINUE, OnFailure.REJECT),
            rule='3.5',
        ),
        _RESULTS,
        _FAULTS,
        PREPARE,
    ),
    misplaced={
        'capabilities': (
            'the conveyor does nothing for an item but move it',
            'give the capabilities to a component',
        ),
        'setups': ('the conveyor has no setups', 'give them to a component'),
        'changes': ('the conveyor has no setups', 'give them to a component'),
        'workspaces': ('the conveyor has no workspace of its own', 'remove `workspaces`'),
        'durations': (
            'the conveyor has one nominal duration for all its tasks',
            'write for instance `duration: 2.0`',
        ),
        'section': ('the conveyor belongs to no section', 'remove `section`'),
        'fails_unless': ('the move of the belt has no result to judge', 'remove `fails_unless`'),
        'identifies': ('the move of the belt has no item to identify', 'remove `identifies`'),
    },
)

CELL = Table(
    'a cell file',
    (
        Key(
            'cell',
            Kind.TEXT,
            'name of the cell, a ROS name token',
            'my_cell',
            required=True,
            form=TOKEN_FORM,
            rule='1',
        ),
        Key(
            'conveyor',
            Kind.TABLE,
            'the indexing belt',
            '{sections: 5, action: /conveyor/index, type: ...}',
            required=True,
            of=(CONVEYOR,),
            rule='3.5',
        ),
        Key(
            'components',
            Kind.MAPPING,
            'device controllers by name',
            '{my_arm: {section: 1, action: /my_arm/task, type: ...}}',
            required=True,
            of=(COMPONENT,),
            fewest=1,
            name_form=NAME_WITHOUT_DOTS,
            rule='1',
        ),
        Key(
            'start',
            Kind.CHOICE,
            'what the `start` of a work order means: its job does not start before it, or may',
            'advisory',
            default=Start.BINDING.value,
            choices=words(Start),
            rule='6.7',
        ),
        Key(
            'release',
            Kind.CHOICE,
            'who releases generated scripts, which do not start without a release; automatic: '
            'every one is released',
            'automatic',
            default=Release.ENGINEER.value,
            choices=words(Release),
            rule='6.10',
        ),
        whole(
            'most_items',
            'most items of one order: a larger one is refused as a slip',
            '50000',
            minimum=1,
            default=MOST_ITEMS,
            rule='6.6',
        ),
        HOLD_AFTER,
        Key(
            'safety',
            Kind.TABLE,
            'topic that says whether goals may be sent at all; this is no safety function',
            '{topic: /safety/ok, type: std_msgs/msg/Bool, field: data, ready: [true]}',
            of=(SAFETY,),
            rule='7.9',
        ),
        Key(
            'first_piece',
            Kind.CHOICE,
            'who approves the first item of jobs that ask for it; automatic: no job waits',
            'operate',
            default=Approval.ENGINEER.value,
            choices=words(Approval),
            rule='6.12',
        ),
    ),
)
