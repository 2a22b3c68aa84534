"""The flat part of the OPC UA server."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.opcua import simple
from tables.markdown import table


def simple_values() -> Iterator[str]:
    """Yield every variable of `Simple`, with its type."""
    groups = (
        ('', simple.CELL),
        ('CurrentJob, NextJob, LastJob: ', simple.JOB),
        ('OldestHold: ', simple.HOLD),
    )
    rows = [
        (f'{where}`{name}`', f'{one.type.name}{"[]" if one.is_list else ""}', one.meaning)
        for where, shown in groups
        for name, one in shown.items()
    ]
    yield from table(
        ('node', 'type', 'meaning'), [('`Connected`', 'Boolean', simple.CONNECTED), *rows]
    )
