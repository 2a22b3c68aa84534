"""Answers of the methods of job control: what they carry, and when they are given."""

from __future__ import annotations

import asyncio
from typing import Any

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.values import Values
from bt_orchestrator.ports.doors.tickets import Outcome
from bt_orchestrator.view.report.isa95.codes import ReturnStatus


def answer(status: ReturnStatus, *outputs: ua.Variant) -> ua.CallMethodResult:
    """Return the result of a call; only Good and Uncertain let the outputs arrive.

    :param outputs: those before ReturnStatus
    """
    is_done = status is ReturnStatus.DONE
    code = ua.StatusCodes.Good if is_done else ua.StatusCodes.Uncertain
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    number = ua.Variant(int(status), ua.VariantType.UInt64)
    result.OutputArguments = [*outputs, number]
    return result


def one(structure: Any) -> ua.Variant:
    """Return a structure as an output."""
    return ua.Variant(structure, ua.VariantType.ExtensionObject)


# A method answers when clients can read what it did: the standard has them look at once.

PATIENCE_S = 1.0
"""Longest wait for the status after a command; what is done stays done without it."""


class Shown:
    """All calls come from the server's loop."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._seq = 0
        self._waiting: list[tuple[int, asyncio.Future[None]]] = []

    def reached(self, seq: int) -> None:
        """Take note of the last event that the values contain."""
        self._seq = seq
        for wanted, future in self._waiting:
            if wanted < seq and not future.done():
                future.set_result(None)
        self._waiting = [one for one in self._waiting if not one[1].done()]

    async def wait(self, outcome: Outcome) -> None:
        """Wait until the values contain what a command did, but not for long."""
        # What follows from the record of a command is recorded behind it, in the same settle.
        wanted = max((event.seq for event in outcome.recorded), default=0)
        if wanted >= self._seq:
            future = asyncio.get_running_loop().create_future()
            self._waiting.append((wanted, future))
            await asyncio.wait([future], timeout=PATIENCE_S)
        await self._values.write()
