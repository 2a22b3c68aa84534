"""The keys of a script and of a work order."""

from __future__ import annotations

from dataclasses import replace

from bt_orchestrator.model.limits import DETAILS_BYTES, INITIALIZATION
from bt_orchestrator.model.script import Release
from bt_orchestrator.script.keys import LARGEST_WHOLE, Key, Kind, Table, whole, words
from bt_orchestrator.script.names import ID_FORM, NAME_WITHOUT_DOTS
from bt_orchestrator.script.orders.instants import INSTANT_FORM
from bt_orchestrator.script.task_keys import INITIALIZATION_TASK, TASK

MOST_ROUNDS = 1000

REPEAT = Table(
    'a repeat',
    (
        Key(
            'repeat',
            Kind.LIST,
            'tasks, run in order, and all again where a verdict refuses a result of one',
            '[{task: ..., action: ...}, {task: ..., action: ...}]',
            required=True,
            of=(TASK,),
            fewest=1,
            rule='3.9',
        ),
        Key(
            'times',
            Kind.WHOLE,
            'further rounds at most',
            '2',
            default=1,
            minimum=1,
            maximum=MOST_ROUNDS,
            rule='3.9',
        ),
    ),
    misplaced={
        'likely': (
            'a repeat is done again as often as a verdict in it refuses',
            'write `likely` beside `fails_unless`',
        ),
    },
)

PARALLEL = Table(
    'a parallel group',
    (
        Key(
            'parallel',
            Kind.LIST,
            'members that run side by side: tasks, lists of tasks run in order, or repeats',
            '[{task: ..., action: ...}, {task: ..., action: ...}]',
            required=True,
            of=(TASK, REPEAT),
            fewest=2,
            is_nested=True,
            rule='3.1',
        ),
    ),
)

SECTION = Table(
    'a section',
    (
        Key(
            'release_conveyor',
            Kind.CHOICE,
            "when the section's turn is complete",
            'after_last_conveyor_task',
            default=Release.END_OF_CYCLE.value,
            choices=words(Release),
            rule='3.8',
        ),
        Key(
            'tasks',
            Kind.LIST,
            'steps, run in order',
            '[{task: ..., action: ...}]',
            required=True,
            of=(TASK, PARALLEL, REPEAT),
            fewest=1,
            rule='3.1',
        ),
    ),
    short='tasks',
)

PARAMETER = Table(
    'a parameter',
    (
        Key(
            'type',
            Kind.CHOICE,
            'type of its values',
            'str',
            required=True,
            choices=('str', 'int', 'float', 'bool'),
            rule='8.1',
        ),
        Key(
            'default',
            Kind.VALUE,
            'used where an order names none; absent: required',
            '"none"',
            rule='8.1',
        ),
    ),
)

INITIALIZATION_DEPENDENCY = Table(
    'an initialization dependency',
    (
        Key('upstream', Kind.TEXT, 'task that is first', 'home_belt', required=True, rule='5.1'),
        Key(
            'downstream',
            Kind.TEXT,
            'task that waits for it',
            'ready_arm',
            required=True,
            rule='5.1',
        ),
    ),
)

LATERAL_DEPENDENCY = Table(
    'a lateral dependency',
    (
        Key(
            'flag',
            Kind.TEXT,
            'name of the counter',
            'camera_clear',
            required=True,
            form=NAME_WITHOUT_DOTS,
            rule='4.1',
        ),
        Key('upstream', Kind.TEXT, 'task that adds one', 'inspect', required=True, rule='4.1'),
        Key('downstream', Kind.TEXT, 'task that takes one', 'assemble', required=True, rule='4.1'),
        whole('capacity', 'upstream starts only below this count', '2', 1, default=1, rule='4.1'),
        whole('initial', 'count at the start, up to the capacity', '1', 0, default=0, rule='4.1'),
    ),
)


def _digest(name: str, meaning: str) -> Key:
    return Key(name, Kind.TEXT, f'{meaning}, by what it says', '"1c2d3e4f5a6b"', rule='8.1')


MADE_FROM = Table(
    'what a script was made from',
    (
        Key(
            'recipe',
            Kind.TEXT,
            'name of the recipe',
            'WM-100',
            required=True,
            form=ID_FORM,
            rule='8.1',
        ),
        Key(
            'version',
            Kind.WHOLE,
            'its version',
            '1',
            required=True,
            minimum=1,
            maximum=LARGEST_WHOLE,
            rule='8.1',
        ),
        _digest('recipe_digest', 'name of the recipe'),
        _digest('cell_digest', 'name of the cell'),
        _digest('overrides_digest', 'name of the overrides, if there were any'),
        _digest(
            'text_digest',
            'name of this file as it was generated, without this key',
        ),
        Key('generator', Kind.TEXT, 'version of the program that wrote it', '"1.0.0"', rule='8.1'),
        Key(
            'without',
            Kind.NAMES,
            'components out of service that could have done one of its operations',
            '[component_4b]',
            rule='6.11',
        ),
    ),
)

PARAMS = Key(
    'params',
    Kind.MAPPING,
    'what a work order may set',
    '{lot: {type: str, default: "none"}}',
    of=(PARAMETER,),
    name_form=NAME_WITHOUT_DOTS,
    rule='8.1',
)

MOST_COUNTED = 1000
"""Items among which rejects are counted, at most."""

HOLD_AFTER = Key(
    'hold_after',
    Kind.TABLE,
    'how many rejects among items begun one after the other hold the line',
    '{rejects: 3, of: 10}',
    of=(
        Table(
            'a limit of rejects',
            tuple(
                Key(
                    name,
                    Kind.WHOLE,
                    meaning,
                    example,
                    required=True,
                    minimum=1,
                    maximum=MOST_COUNTED,
                    rule='7.7',
                )
                for name, meaning, example in (
                    ('rejects', 'rejects that hold the line, not more than `of`', '3'),
                    ('of', 'items among which they are counted', '10'),
                )
            ),
        ),
    ),
    rule='7.7',
)

FIRST_PIECE = Key(
    'first_piece',
    Kind.SWITCH,
    'the first item of each job has to be approved before its second one begins',
    'true',
    default=False,
    rule='6.12',
)

LOTS = Key(
    'lots',
    Kind.MAPPING,
    'what goes into each item, by name: texts with values of the order',
    '{glue: "${params.glue_lot}"}',
    members=Kind.TEXT,
    name_form=NAME_WITHOUT_DOTS,
    rule='6.9',
)

SCRIPT = Table(
    'a script',
    (
        Key(
            'script',
            Kind.TEXT,
            'name of the script',
            'my_process',
            required=True,
            form=ID_FORM,
            rule='1',
        ),
        Key(
            'made_from',
            Kind.TABLE,
            'where a generated script comes from; changes nothing of what it does',
            '{recipe: WM-100, version: 1}',
            of=(MADE_FROM,),
            rule='8.1',
        ),
        whole('quantity', 'items of an order that names no quantity', '12', 1, rule='6.2'),
        PARAMS,
        LOTS,
        HOLD_AFTER,
        FIRST_PIECE,
        Key(
            'initialization',
            Kind.LIST,
            f'tasks before the first cycle of a job, {INITIALIZATION} at most',
            '[{id: home_belt, task: HOME, action: /conveyor/index}]',
            of=(INITIALIZATION_TASK,),
            rule='5.2',
        ),
        Key(
            'initialization_dependencies',
            Kind.LIST,
            'order among initialization tasks; all others run side by side',
            '[{upstream: home_belt, downstream: ready_arm}]',
            of=(INITIALIZATION_DEPENDENCY,),
            rule='5.1',
        ),
        Key(
            'sections',
            Kind.MAPPING,
            'task list of each section, by number: a list of steps, or {release_conveyor, tasks}',
            '{1: [{task: ..., action: ...}]}',
            required=True,
            of=(SECTION,),
            fewest=1,
            name_form='[1-9][0-9]*',
            rule='3.1',
        ),
        Key(
            'lateral_dependencies',
            Kind.LIST,
            'counters that order tasks of different sections',
            '[{flag: camera_clear, upstream: inspect, downstream: assemble}]',
            of=(LATERAL_DEPENDENCY,),
            rule='4.1',
        ),
        Key(
            'zones',
            Kind.MAPPING,
            'tasks that must never overlap, by the name of the workspace they share',
            '{shared_table: [inspect, assemble]}',
            members=Kind.LIST,
            name_form=NAME_WITHOUT_DOTS,
            rule='4.4',
        ),
    ),
)


def _instant(name: str, meaning: str, example: str, rule: str) -> Key:
    return Key(name, Kind.INSTANT, meaning, example, form=INSTANT_FORM, rule=rule)


ORDER = Table(
    'a work order',
    (
        Key('order', Kind.TEXT, 'order id; assigned when absent', 'WO-1001', rule='6.6'),
        Key(
            'script',
            Kind.TEXT,
            'name of a script, or a path; for a node, below its folders of scripts',
            'my_process',
            rule='8.1',
        ),
        Key(
            'recipe',
            Kind.NAMES,
            'in place of `script`: name of a recipe, or of several: the first that can be made',
            'WM-100',
            fewest=1,
            rule='8.6',
        ),
        whole('version', 'version of the recipe; absent: the newest', '2', 1, rule='8.6'),
        Key(
            'bind',
            Kind.MAPPING,
            'component that does an operation of the recipe, by the id of the operation',
            '{insert: component_3a}',
            members=Kind.TEXT,
            rule='8.6',
        ),
        whole('quantity', "number of items; absent: the script's", '12', 1, rule='6.2'),
        Key(
            'params',
            Kind.MAPPING,
            'values for the parameters of the script',
            '{lot: A7}',
            members=Kind.VALUE,
            rule='8.1',
        ),
        Key(
            'priority',
            Kind.WHOLE,
            'the higher the more urgent, as Priority in ISA-95 Job Control',
            '10',
            default=0,
            minimum=-(2**15),
            maximum=2**15 - 1,
            rule='6.7',
        ),
        _instant('start', 'its job does not begin before it', '2026-05-18T06:00:00+02:00', '6.7'),
        _instant(
            'due', 'when it should have ended, not before `start`', '2026-05-18T12:00:00Z', '6.6'
        ),
        replace(FIRST_PIECE, meaning='its first item has to be approved before the second begins'),
        Key(
            'details',
            Kind.MAPPING,
            f'anything that JSON can say, {DETAILS_BYTES} bytes at most; kept and told',
            '{customer: ACME, numbers: [4711, 4712]}',
            members=Kind.JSON,
            rule='6.6',
        ),
    ),
    rivals=(('script', 'recipe'), ('script', 'version'), ('script', 'bind')),
    one_of=('script', 'recipe'),
)
