"""A log that other programs cannot fill: lines that their messages cause are limited."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from typing import Protocol

from bt_orchestrator.model.limits import LOG_LINES, MESSAGE, Allowance, cut


class Logger(Protocol):
    """The part of a ROS 2 logger that is needed here."""

    def error(self, message: str) -> object:
        """Report an error."""

    def warning(self, message: str) -> object:
        """Report something odd."""


class SpareLog:
    """Passes the first lines on, and later only a few, each with the number of those left out."""

    def __init__(self, logger: Logger) -> None:
        self._logger = logger
        self._allowance = Allowance(LOG_LINES)
        self._left_out = 0

    def error(self, message: str) -> None:
        """Report an error."""
        if self._may_say():
            self._logger.error(self._line(message))

    def warning(self, message: str) -> None:
        """Report something odd."""
        if self._may_say():
            self._logger.warning(self._line(message))

    def _may_say(self) -> bool:
        now = time.monotonic()
        if self._allowance.left(now) < 1:
            self._left_out += 1
            return False
        self._allowance.use(1, now)
        return True

    def _line(self, message: str) -> str:
        left_out, self._left_out = self._left_out, 0
        more = f' ({left_out} lines before this one were left out)' if left_out else ''
        return cut(message, MESSAGE) + more


# What callbacks raise: rclpy would end the executor's loop.


def guarded(callback: Callable[[], object], logger: Logger) -> Callable[[], None]:
    """Return a callback that reports what it raises, and raises nothing."""

    def call() -> None:
        try:
            callback()
        except Exception:  # noqa: BLE001 - whatever it is, the others go on
            report(logger)

    return call


def report(logger: Logger) -> None:
    """Report the exception that is being handled."""
    text = f'error in a callback, ignored:\n{traceback.format_exc()}'
    logger.error(text)
