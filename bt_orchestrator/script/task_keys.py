"""The keys of a task, in a section's list and in the initialization list."""

from __future__ import annotations

from dataclasses import replace

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.conditions.condition_keys import CONDITION, LIKELY_KEY
from bt_orchestrator.script.keys import LONGEST_SECONDS, Key, Kind, Table, action, whole, words
from bt_orchestrator.script.names import ID_FORM

_FIRST_TASK_KEYS = (
    Key(
        'id',
        Kind.TEXT,
        'name of the task in the script; else section and number',
        'inspect',
        form=ID_FORM,
        rule='1',
    ),
    Key(
        'task',
        Kind.TEXT,
        'task constant of the action type; a label where the type has no task field',
        'TASK_A',
        rule='2.1',
    ),
    action(),
    Key(
        'args',
        Kind.MAPPING,
        'goal fields; references are allowed',
        '{label: "${params.lot}"}',
        rule='6.3',
    ),
)
_LAST_TASK_KEYS = (
    Key(
        'continue_if_fail',
        Kind.SWITCH,
        'true means `on_failure: continue`',
        'true',
        default=False,
        rule='2.7',
    ),
    replace(
        whole('retries', 'further attempts after a failed one', '2', 0, default=0, rule='2.6'),
        sets='retries',
    ),
    Key(
        'retry_delay',
        Kind.SECONDS,
        'seconds before a further attempt',
        '1.0',
        default=0.0,
        minimum=0,
        maximum=LONGEST_SECONDS,
        rule='2.6',
        sets='retry_delay_s',
    ),
    Key(
        'timeout',
        Kind.TIMEOUT,
        "seconds from sending; none: no limit; absent: the component's, else 300",
        '10.0',
        minimum=0,
        maximum=LONGEST_SECONDS,
        rule='2.4',
        sets='timeout_s',
    ),
    Key(
        'repeatable',
        Kind.SWITCH,
        'doing it twice does no harm, so it may be sent again after a crash',
        'true',
        default=False,
        rule='9.2',
        sets='repeatable',
    ),
)


def _on_failure(choices: tuple[str, ...]) -> Key:
    meaning = 'what happens after the last failed attempt; absent: hold'
    return Key('on_failure', Kind.CHOICE, meaning, 'hold', choices=choices, rule='2.7')


TASK = Table(
    'a task',
    (
        *_FIRST_TASK_KEYS,
        Key(
            'requires_conveyor',
            Kind.SWITCH,
            'the belt must be at rest for it',
            'false',
            default=True,
            rule='3.3',
            sets='requires_conveyor',
        ),
        Key(
            'qty_change',
            Kind.WHOLE,
            '1: places the item, -1: takes it out',
            '1',
            default=0,
            minimum=-1,
            maximum=1,
            rule='3.2',
            sets='qty_change',
        ),
        _on_failure(words(OnFailure)),
        *_LAST_TASK_KEYS,
        Key(
            'when',
            Kind.CONDITION,
            'run only if this holds; else the task is skipped',
            '"${results.weigh.item_present}"',
            of=(CONDITION,),
            rule='6.5',
        ),
        Key(
            'unless',
            Kind.CONDITION,
            'skip the task if this holds',
            '"${results.weigh.item_present}"',
            of=(CONDITION,),
            rule='6.5',
        ),
        Key(
            'fails_unless',
            Kind.CONDITION,
            'what has to hold of its results; else the attempt has failed',
            '{value: "${results.inspect.measurement}", between: [4.5, 5.5]}',
            of=(CONDITION,),
            rule='2.8',
        ),
        Key(
            'identifies',
            Kind.TEXT,
            "result field that is the item's serial, text or a whole number",
            'serial',
            rule='6.8',
        ),
        Key(
            'runs_for',
            Kind.CHOICE,
            'items that it runs for',
            'all',
            default=RunsFor.GOOD.value,
            choices=words(RunsFor),
            rule='6.4',
            sets='runs_for',
        ),
        LIKELY_KEY,
        Key(
            'setup',
            Kind.MAPPING,
            'values that setups of its component must have',
            '{gripper: large}',
            members=Kind.TEXT,
            fewest=1,
            rule='5.3',
        ),
    ),
    misplaced={'once': ('only initialization tasks can run once', 'remove `once`')},
    rivals=(('continue_if_fail', 'on_failure'), ('when', 'unless')),
)

_NO_ITEM = 'initialization has no items, so `{}` means nothing there'

INITIALIZATION_TASK = Table(
    'an initialization task',
    (
        *_FIRST_TASK_KEYS,
        _on_failure(words(OnFailure, OnFailure.REJECT)),
        *_LAST_TASK_KEYS,
        Key(
            'once',
            Kind.SWITCH,
            'skip it if the same was done last since the cell left Stopped or Aborted',
            'true',
            default=False,
            rule='5.1',
            sets='once',
        ),
    ),
    misplaced={
        key: (_NO_ITEM.format(key), f'remove `{key}`')
        for key in (
            *('requires_conveyor', 'qty_change', 'when', 'unless', 'identifies', 'runs_for'),
            'likely',
        )
    }
    | {
        'setup': (
            'initialization asks for no setup',
            'remove `setup`, or write a change as a task',
        ),
        'fails_unless': (
            'the results of initialization are not kept, so `fails_unless` cannot judge them',
            'remove `fails_unless`',
        ),
    },
    rivals=(('continue_if_fail', 'on_failure'),),
)
