"""The flat part of the OPC UA server, and PackML in numbers."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.extensions.opcua.mes.alarms import STOP_IDS
from bt_orchestrator.extensions.opcua.mes.packml import COMMANDS, STATE_NUMBERS, WITHOUT
from bt_orchestrator.extensions.opcua.server import simple
from bt_orchestrator.extensions.opcua.server.packml_values import VALUE_MEANINGS
from tables.markdown import cell, table


def simple_values() -> Iterator[str]:
    """Yield every variable of `Simple`, with its type."""
    groups = (
        ('', simple.CELL),
        ('CurrentJob, NextJob, LastJob: ', simple.JOB),
        ('OldestHold: ', simple.HOLD),
        ('Manual: ', simple.GOAL),
        ('Reasons: ', {**simple.REASONS, 'en, de, ...': simple.REASON_WORDS}),
    )
    rows = [
        (f'{where}`{name}`', f'{one.type.name}{"[]" if one.is_list else ""}', one.meaning)
        for where, shown in groups
        for name, one in shown.items()
    ]
    yield from table(
        ('node', 'type', 'meaning'), [('`Connected`', 'Boolean', simple.CONNECTED), *rows]
    )


def states_in_numbers() -> Iterator[str]:
    """Yield StateCurrent of every state."""
    by_number = sorted(STATE_NUMBERS.items(), key=lambda one: one[1])
    yield from table(
        ('number', 'state'), ((str(number), state.value) for state, number in by_number)
    )


def values_of_packml() -> Iterator[str]:
    """Yield the variables below PackML."""
    yield from table(
        ('node', 'meaning'), ((f'`{path}`', cell(one)) for path, one in VALUE_MEANINGS.items())
    )


def commands_of_packml() -> Iterator[str]:
    """Yield what each method of the nodeset does, or why there is none."""
    yield from table(
        ('method', 'here'),
        (
            *(
                (f'`{name}`', f'`{one.word}`: {cell(one.effect)}')
                for name, one in COMMANDS.items()
            ),
            *((f'`{name}`', f'not there: {cell(why)}') for name, why in WITHOUT.items()),
        ),
    )


def stop_numbers() -> Iterator[str]:
    """Yield the numbers of stop reasons, with the severity of their conditions."""
    yield from table(
        ('ID', 'reason', 'condition of severity', 'means'),
        (
            (str(one.number), one.word or '-', str(one.severity or '-'), cell(one.meaning))
            for one in STOP_IDS
        ),
    )
