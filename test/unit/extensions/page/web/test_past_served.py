"""The past and the scripts as the page serves them, with a journal file and without."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from fakes.shipped import TREES
from patience import PATIENCE_S
from web.stand_cell import StandCell

from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.page import WebPage
from bt_orchestrator.extensions.page.web.seams import Sources
from bt_orchestrator.extensions.page.web.server import PageServer
from bt_orchestrator.model.codec import from_plain
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore

JOB = 'WO-1'


class Served:
    """A cell that has made two items."""

    def __init__(self, folder: Path) -> None:
        self.journal = folder / 'cell.sqlite3'
        self.cell = StandCell(folder, MemoryStore(), faults=[], speed=200.0)
        assert self.cell.queue(WorkOrder(self.cell.script, JOB, 2)).accepted

    @contextmanager
    def page(self, *, with_journal: bool) -> Iterator[PageServer]:
        opened = partial(SqliteRecords, self.journal) if with_journal else None
        access = Access(Path('no users'), '127.0.0.1', 0)
        sources = Sources(opened, (TREES,))
        server = PageServer(WebPage(self.cell.node.name, self.cell.open_door, access, sources))
        with server.running():
            deadline = time.monotonic() + PATIENCE_S
            while get(server, '/api/events?most=1')[0] == 503:
                assert time.monotonic() < deadline, 'the page hears nothing of the node'
                time.sleep(0.01)
            yield server

    def write(self) -> None:
        """Write the journal: one that a node in another process would have written."""
        with self.cell.lock, closing(SqliteStore(self.journal)) as store:
            store.append(list(self.cell.store.read()))

    def ended(self) -> bool:
        with self.cell.lock:
            state = self.cell.node.running.engine.state
            return JOB in state.ended and state.packml is PackmlState.COMPLETE


@pytest.fixture(scope='module')
def served(tmp_path_factory: pytest.TempPathFactory) -> Served:
    served = Served(tmp_path_factory.mktemp('served'))
    with served.page(with_journal=False):  # the time of the cell passes while it is followed
        deadline = time.monotonic() + PATIENCE_S
        while not served.ended():
            assert time.monotonic() < deadline, 'the job does not end'
            time.sleep(0.01)
    served.write()
    return served


def get(server: PageServer, path: str) -> tuple[int, Any]:
    status, body, _ = fetched(server, path)
    return status, json.loads(body)


def fetched(
    server: PageServer, path: str, headers: dict[str, str] | None = None
) -> tuple[int, bytes, dict[str, str]]:
    connection = http.client.HTTPConnection('127.0.0.1', server.port, timeout=PATIENCE_S)
    try:
        connection.request('GET', path, headers=headers or {})
        response = connection.getresponse()
        return response.status, response.read(), dict(response.getheaders())
    finally:
        connection.close()


PATHS = (
    '/api/jobs?most=3',
    f'/api/jobs/{JOB}',
    f'/api/items/{JOB}/2',
    '/api/events?kinds=job.,item.removed&most=5',
    '/api/events?after=3&most=4',
    '/api/components/component_1a/history',
    '/api/sections/2/history',
    '/api/alarms',
)


def test_page_answers_equally_without_journal(served: Served) -> None:
    with served.page(with_journal=True) as archive, served.page(with_journal=False) as other:
        for path in PATHS:
            stored, heard = get(archive, path), get(other, path)
            assert stored[0] == 200, path
            assert heard[1]['is_whole'], path
            assert 'give the page the journal that the node writes' in stored[1]['why_not']
            for answer in (stored[1], heard[1]):
                del answer['is_whole'], answer['why_not']
                answer.pop('time_in', None)  # up to now
                answer.pop('history', None)  # the file is a copy
            assert stored == heard, path


@pytest.mark.parametrize(
    ('path', 'status', 'words'),
    [
        ('/api/jobs/X', 404, 'nothing is known here of job X'),
        (f'/api/items/{JOB}/77', 404, f'nothing is known here of item {JOB}/77'),
        ('/api/jobs?after=what', 422, 'after is what an answer named as rest'),
        ('/api/jobs?after=e1x', 422, 'after is what an answer named as rest'),
        ('/api/events?after=-1', 422, 'after is a whole number'),
        ('/api/events?most=many', 422, 'most is a whole number'),
        (f'/api/events?kinds={"a," * 101}', 422, 'kinds are at most 100 names; found 101'),
        ('/api/sections/6/history', 404, 'sections are 1 to 5; found 6'),
        ('/api/components/nobody/history', 404, 'there is no component nobody; one of conveyor'),
        ('/api/alarms?kind=x', 422, 'kind is one of hold, emergency, contest, silent, refused'),
        ('/api/scripts/0123', 404, 'no script with the digest 0123'),
        ('/api/drawing/0123.svg', 404, 'no script with the digest 0123'),
        ('/api/tree?after=x', 422, 'after is the version'),
    ],
)
def test_what_is_not_there_is_said(served: Served, path: str, status: int, words: str) -> None:
    with served.page(with_journal=True) as server:
        get(server, '/api/scripts')
        assert get(server, '/api/tree')[0] == 200  # the cell is known from here on
        answer = get(server, path)
    assert answer[0] == status
    assert words in answer[1]['message']


def test_a_journal_that_is_gone_is_said(served: Served, tmp_path: Path) -> None:
    access = Access(Path('no users'), '127.0.0.1', 0)
    sources = Sources(partial(SqliteRecords, tmp_path / 'none'))
    server = PageServer(WebPage(served.cell.node.name, served.cell.open_door, access, sources))
    with server.running():
        status, answer = get(server, '/api/jobs')
    assert (status, 'there is no journal' in answer['message']) == (503, True)


def test_scripts_and_a_drawing_that_is_sent_once(served: Served) -> None:
    with served.page(with_journal=True) as server:
        _, listed = get(server, '/api/scripts')
        names = {entry['name'] for entry in listed}
        assert served.cell.script in names
        _, events = get(server, '/api/events?kinds=script.loaded')
        digest = events['records'][0]['digest']
        status, script = get(server, f'/api/scripts/{digest}')
        assert (status, script['name']) == (200, served.cell.script)
        assert set(script['sections']) == {'1', '2', '3', '4', '5'}
        path = f'/api/drawing/{digest}.svg'
        status, svg, headers = fetched(server, path)
        assert (status, headers['content-type']) == (200, 'image/svg+xml')
        assert b'component_1a' in svg
        again = fetched(server, path, {'If-None-Match': headers['etag']})
        assert again[:2] == (304, b'')
        assert fetched(server, f'{path}?live=1')[2]['etag'] != headers['etag']


def test_tree_is_sent_whole_only_once(served: Served) -> None:
    with served.page(with_journal=False) as server:
        status, first = get(server, '/api/tree')
        assert status == 200
        assert {'section 1', 'belt'} <= {child['name'] for child in first['tree']['children']}
        assert get(server, f'/api/tree?after={first["version"]}')[1]['tree'] is None


def test_page_without_news_claims_no_empty_past(
    tmp_path: Path,
) -> None:
    served = Served(tmp_path)
    served.cell.switch()
    access = Access(Path('no users'), '127.0.0.1', 0)
    server = PageServer(WebPage(served.cell.node.name, served.cell.open_door, access))
    with server.running():
        answer = get(server, '/api/jobs')
    words = 'nothing was heard of /bt_orchestrator yet'
    assert answer == (503, {'message': words, 'said': {'de': words, 'en': words}})


def test_the_whole_status_of_now(served: Served) -> None:
    with served.page(with_journal=False) as server:
        status, cell = get(server, '/api/cell')
    assert status == 200
    assert cell['node'] == served.cell.node.name
    assert from_plain(CellStatus, cell['status']).state is PackmlState.COMPLETE
    assert cell['status']['journal_failure'] == '', 'defaults are there as well'


def test_a_cell_that_was_never_heard(tmp_path: Path) -> None:
    served = Served(tmp_path)
    served.cell.switch()
    access = Access(Path('no users'), '127.0.0.1', 0)
    server = PageServer(WebPage(served.cell.node.name, served.cell.open_door, access))
    with server.running():
        status, answer = get(server, '/api/cell')
    assert (status, answer['message']) == (503, 'nothing was heard of /bt_orchestrator yet')
