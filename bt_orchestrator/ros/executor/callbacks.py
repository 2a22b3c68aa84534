"""A callback's exception is reported, and never ends the process."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Protocol


class Logger(Protocol):
    """The part of a ROS 2 logger that is needed here."""

    def error(self, message: str) -> object:
        """Report an error."""


def guarded(callback: Callable[[], object], logger: Logger) -> Callable[[], None]:
    """Return a callback that reports what it raises; rclpy would end the executor's loop."""

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
