"""Errors in callbacks."""

from __future__ import annotations

from bt_orchestrator.sim.controllers.task_server import guarded


class Lines:
    """A logger that remembers."""

    def __init__(self) -> None:
        self.errors: list[str] = []

    def error(self, message: str) -> None:
        self.errors.append(message)


def test_an_error_is_reported_and_goes_no_further() -> None:
    log = Lines()

    guarded(lambda: 1 // 0, log)

    assert 'ZeroDivisionError' in log.errors[0]


def test_without_an_error_nothing_is_reported() -> None:
    log = Lines()
    called: list[bool] = []

    guarded(lambda: called.append(True), log)

    assert called == [True]
    assert not log.errors
