"""A request of `~/command` as a command to the cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import cell_commands as c
from bt_orchestrator.model.belt_statement import AsShown, Statement, parse_slots
from bt_orchestrator.model.by import By
from bt_orchestrator.ros.services.serving import by


def command_of(request: Any) -> c.CellCommand:
    """Return the command of a request (bt_orchestrator_interfaces/srv/Command).

    :raises CommandRefused: there is no such command, or `clear` does not say what is on the belt
    """
    make = _MAKERS.get(request.command)
    if make is None:
        known = ', '.join(_MAKERS)
        raise CommandRefused(f'unknown command {request.command!r}; one of {known}')
    return make(request, by(request))


def _resume(request: Any, said: By) -> c.Resume:
    return c.Resume(said, hold=request.hold or None, everyones=request.everyones)


def _clear(request: Any, said: By) -> c.Clear:
    return c.Clear(said, belt=_statement(request))


def _statement(request: Any) -> Statement:
    if bool(request.belt) == bool(request.as_shown):
        raise CommandRefused(
            'clear needs to know what stands on the belt: either every slot, as in 1=WO-1/3 and '
            '2=empty, or the seq of the status that shows the belt as it is'
        )
    return parse_slots(request.belt) if request.belt else AsShown(request.as_shown)


_MAKERS: Mapping[str, Callable[[Any, By], c.CellCommand]] = {
    'reset': lambda _, said: c.Reset(said),
    'start': lambda _, said: c.Start(said),
    'pause': lambda _, said: c.Pause(said),
    'resume': _resume,
    'stop': lambda _, said: c.Stop(said),
    'abort': lambda _, said: c.Abort(said),
    'clear': _clear,
}
