"""A journal without its first events: what begins after them is whole all the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from fakes.line import THREE, Line
from fakes.page_bench import PeopleBench
from fakes.virtual_run import VirtualRun

from bt_orchestrator.extensions.page.web.archive import Archive, endpoints
from bt_orchestrator.extensions.page.web.archive.heard import HeardRecords
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.ports.doors.following_door import Happened


class Nothing:
    """A cell of which nothing was heard."""

    status = None
    description = None


class Bench(PeopleBench):
    """A page that knows the events from the second job on."""

    def __init__(self, folder: Path) -> None:
        line = Line(3)
        run = VirtualRun(line.cell, line.types)
        for job in ('OLD', 'NEW'):
            run.submit(job, line.script(THREE), 2)
            run.go()
        events = list(run.store.read())
        (begin,) = (event['seq'] for event in run.all('job.queued', job='NEW'))
        kept = [Happened(event) for event in events if event.seq >= begin]
        records = HeardRecords('', begin - 1, kept)
        self._archive = Archive(cast('Any', None), lambda: records)
        super().__init__(folder)

    def endpoints(self) -> Sequence[Endpoint]:
        return endpoints(self._archive, Nothing())

    def close(self) -> None:
        self._archive.close()
        super().close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.close()


@pytest.mark.parametrize('path', ['/api/jobs/NEW', '/api/items/NEW/1'])
def test_what_begins_after_the_removed_events_is_whole(bench: Bench, path: str) -> None:
    answer = bench.browser().get(path).json
    assert (answer['is_whole'], answer['why_not']) == (True, '')
    assert 'has_beginning' not in answer


@pytest.mark.parametrize('path', ['/api/jobs', '/api/events', '/api/sections/2/history'])
def test_history_with_removed_beginning_is_marked_incomplete(bench: Bench, path: str) -> None:
    answer = bench.browser().get(path).json
    assert not answer['is_whole']
    assert 'not in the journal any more' in answer['why_not']
