"""The record of what really happened."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic

from bt_orchestrator.model.cell import Component
from bt_orchestrator.sim.controllers.component_server import GoalLog

COMPONENT = Component('arm', (1,), '/arm/task', 'p/action/T')


def test_line_is_readable_before_file_is_closed(tmp_path: Path) -> None:
    path = tmp_path / 'goals.jsonl'
    log = GoalLog(path)

    before = round(monotonic(), 6)
    log.write(12.5, 'started', COMPONENT, goal='7', task='A')

    record = json.loads(path.read_text())
    assert before <= record.pop('steady') <= monotonic() + 1e-6
    assert record == {
        'time': 12.5,
        'event': 'started',
        'component': 'arm',
        'action': '/arm/task',
        'goal': '7',
        'task': 'A',
    }
    log.close()


def test_a_file_that_exists_is_continued(tmp_path: Path) -> None:
    path = tmp_path / 'goals.jsonl'
    for event in ('started', 'ended'):
        log = GoalLog(path)
        log.write(1.0, event, COMPONENT)
        log.close()

    assert [json.loads(line)['event'] for line in path.read_text().splitlines()] == [
        'started',
        'ended',
    ]


def test_without_a_file_nothing_is_written(tmp_path: Path) -> None:
    log = GoalLog(None)
    log.write(1.0, 'started', COMPONENT)
    log.close()

    assert not list(tmp_path.iterdir())
