"""The descriptions of PackML nodes; the page about the server has the same table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from bt_orchestrator.extensions.opcua.mes.packml import COMMANDS, Machine

VALUES: Mapping[str, str] = {
    'Status/StateCurrent': 'number of the state, as in the tag Status.StateCurrent',
    'Status/StateChangeInProcess': 'it is an acting state, which ends by itself',
    'Status/EquipmentStarved': 'the line waits for its source, and goes on by itself',
    'Status/EquipmentBlocked': 'the line waits for its sink, and goes on by itself',
    'Status/CurMachSpeed': (
        'moves of the belt a minute, over the last ten; each brings every item one section '
        'further. 0 outside of Execute, UncertainInitialValue until two moves were seen; it '
        'falls while a move is overdue'
    ),
    'Status/MachSpeed': 'BadNotSupported, as its range: the speed of the line cannot be set',
    'Status/UnitModeCurrent': '1, Produce: the only mode',
    'Admin/StateCurrentTime': 'seconds of the present stay, by unit mode and state',
    'Admin/StateCumulativeTime': 'seconds since the journal began, by unit mode and state',
    'Admin/ProdProcessedCount': (
        'items produced, good or bad: packed, rejected or taken off by hand. An element for each '
        'job on the line, the oldest first, else for the last job. Name: its id; Count: its own; '
        'AccCount: of all jobs'
    ),
    'Admin/ProdDefectiveCount': (
        'the same of items that are not good: rejected, nonconforming, or taken off by hand'
    ),
    'Admin/StopReason': (
        'why the line stands still: ID and Category are numbers that never change, Value is the '
        'number of the hold that decides it, DateTime since when; Trigger is false while it runs'
    ),
    'LastRefusal': 'why the last command was refused',
    'Belt': 'what stands on the belt of an aborted cell, for ClearAsShown; else empty',
}
"""Variables, by their path below PackML."""

_OBJECTS: Mapping[str, str] = {
    '': 'the cell in the words of PackML (OPC 30050)',
    '/Admin': 'times, counters, and why the line stands still',
    '/Status': 'state, speed, and whether source and sink are ready',
    '/Status/UnitSupportedModes': 'the unit modes that the cell has',
    '/PackMLVersion': 'edition of PackML that the states follow',
    f'/{Machine.BASE.value}': 'Cleared, Aborting or Aborted; the machine inside is for Cleared',
    f'/{Machine.MACHINE.value}': (
        'Running, Stopping, Stopped or Clearing; the machine inside is for Running'
    ),
    f'/{Machine.EXECUTE.value}': 'the states of a line that was started',
}
_NOT_OURS: Mapping[str, str] = {
    '/SetUnitMode': 'takes 1, Produce; else BadNotSupported: there is no other mode',
    '/SetMachSpeed': 'BadNotSupported: the speed of the line cannot be set',
    '/SetProduct': 'BadNotSupported: an order says what is made',
    '/SetParameter': 'BadNotSupported: an order has the parameters',
}

METHODS: Mapping[Machine, tuple[str, ...]] = {
    Machine.BASE: ('Abort',),
    Machine.MACHINE: ('Reset', 'Stop'),
    Machine.EXECUTE: ('Reset', 'Start', 'Hold', 'Unhold'),
}
"""Where the nodeset has the commands."""


def meanings(top: str) -> Iterator[tuple[str, str]]:
    """Yield the path and the meaning of each node that is not made with one.

    :param top: path of PackML
    """
    yield from ((f'{top}/{path}', meaning) for path, meaning in VALUES.items())
    for below, meaning in {**_OBJECTS, **_NOT_OURS}.items():
        yield f'{top}{below}', meaning
    for machine, names in METHODS.items():
        for name in names:
            yield f'{top}/{machine.value}/{name}', COMMANDS[name].effect
