"""When a simulated controller says that it is ready."""

from __future__ import annotations

from collections.abc import Callable

from bt_orchestrator.model.fault import Fault, FaultKind
from bt_orchestrator.ports import Timer
from bt_orchestrator.sim.fault_schedule import FaultSchedule


class Readiness:
    """Ready whenever it comes up, but for the faults; silent all the time if told so."""

    def __init__(
        self,
        schedule: FaultSchedule,
        announce: Callable[[bool], None],
        after: Callable[[float, Callable[[], None]], Timer],
    ) -> None:
        """Begin without a word.

        :param announce: shows whether it is ready
        :param after: calls back in so many simulated seconds
        """
        self._schedule = schedule
        self._announce = announce
        self._after = after
        self._ready_again: Timer | None = None

    def begin(self, not_ready: Fault | None) -> None:
        """Say how it is when the server comes up."""
        if not_ready is None:
            self._say(ready=True)
        self.withdraw(not_ready)

    def withdraw(self, fault: Fault | None) -> None:
        """Become not ready, for as long as the fault says."""
        if fault is None:
            return
        if self._ready_again is not None:
            self._ready_again.cancel()
        self._say(ready=False)
        if fault.seconds is not None:
            self._ready_again = self._after(fault.seconds, lambda: self._say(ready=True))

    def _say(self, *, ready: bool) -> None:
        if self._schedule.at_start(FaultKind.SILENT) is None:
            self._announce(ready)
