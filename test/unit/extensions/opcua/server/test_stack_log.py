"""What asyncua writes does not fill the log of the server."""

from __future__ import annotations

import logging

import pytest

from bt_orchestrator.extensions.opcua.server.library import stack_log
from bt_orchestrator.model.limits import LOG_LINES


def test_a_line_for_each_and_not_without_end(
    caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    log = logging.getLogger('asyncua.server.uaprocessor')
    with stack_log():
        for number in range(1000):
            try:
                raise ValueError(number)
            except ValueError:
                log.exception('while processing a message')
        log.info('a request')
    lines = [record.getMessage() for record in caplog.records]
    assert lines[0] == 'asyncua: while processing a message: ValueError: 0'
    assert len(lines) < LOG_LINES.at_once + 5
    assert all(record.exc_info is None for record in caplog.records)
    assert all(
        record.name.startswith('bt_orchestrator.extensions.opcua.server')
        for record in caplog.records
    )
    assert capsys.readouterr().err == ''
    log.warning('as it was')
    assert caplog.records[-1].name == log.name
