"""The outputs of the methods of job control: a failed call carries its ReturnStatus, too."""

from __future__ import annotations

from typing import Any

from asyncua import ua

from bt_orchestrator.view.report.isa95.return_status import ReturnStatus


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
