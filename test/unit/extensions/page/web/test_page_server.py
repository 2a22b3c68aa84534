"""The page with a real server on a free port, and a cell in virtual time behind it."""

from __future__ import annotations

import gc
import http.client
import json
import socket
import ssl
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fakes.certificates import make_certificate
from patience import PATIENCE_S
from web.sse_client import SseClient
from web.stand_cell import StandCell

from bt_orchestrator.extensions.page.web import server as server_module
from bt_orchestrator.extensions.page.web import stream as stream_module
from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.page import WebPage
from bt_orchestrator.extensions.page.web.server import PageServer
from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.ports import EventStore
from bt_orchestrator.ports.doors.listening import CannotListen
from bt_orchestrator.store.memory import MemoryStore

SPEED = 20.0


class Forgetful(MemoryStore):
    """A journal whose first events were removed."""

    KEPT_FROM = 11

    def first_seq(self) -> int:
        return self.KEPT_FROM

    def read(self, after: int = 0, most: int = -1) -> Sequence[Event]:
        return super().read(max(after, self.KEPT_FROM - 1), most)


def access(host: str = '127.0.0.1', port: int = 0) -> Access:
    return Access(Path('no users'), host, port)


class Scene:
    """A cell, and pages of it that come and go."""

    def __init__(self, folder: Path, store: EventStore | None = None) -> None:
        self.cell = StandCell(folder, store or MemoryStore(), faults=[], speed=SPEED)

    @contextmanager
    def page(self) -> Iterator[PageServer]:
        server = PageServer(WebPage(self.cell.node.name, self.cell.open_door, access()))
        with server.running():
            yield server

    def work(self, *orders: str) -> None:
        """Queue orders of one item each."""
        answer = self.cell.queue(*(WorkOrder(self.cell.script, order, 1) for order in orders))
        assert answer.accepted, answer

    def wait_until(self, condition: Callable[[], object], what: str) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < deadline, what
            time.sleep(0.01)

    def last_seq(self) -> int:
        """Return the number of the last event there is."""
        with self.cell.lock:
            return len(list(self.cell.store.read()))


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def get(server: PageServer, path: str) -> tuple[int, Any]:
    connection = http.client.HTTPConnection('127.0.0.1', server.port, timeout=PATIENCE_S)
    try:
        connection.request('GET', path)
        response = connection.getresponse()
        return response.status, json.loads(response.read())
    finally:
        connection.close()


def readers(server: PageServer) -> int:
    return int(get(server, '/healthz')[1]['readers'])


class TestStream:
    def test_stream_starts_complete_and_follows_events(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            begin = reader.first('begin').data
            assert begin['node'] == '/bt_orchestrator'
            everything = reader.first('parts').data['set']
            assert everything['cell']['name'] == 'reference_cell'
            scene.work('WO-1')
            last = begin['after'] + 20
            assert reader.seqs(last)[:20] == list(range(begin['after'] + 1, last + 1))

    def test_records_are_those_of_the_journal(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            reader.first('begin')
            scene.work('WO-1')
            for record in reader.first('happened').data['records']:
                (event,) = scene.cell.store.read(record['seq'] - 1, 1)
                assert record == json.loads(json.dumps(to_record(event)))

    def test_there_is_a_beat_each_second(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            first, second = reader.first('beat').data, reader.first('beat').data
            assert 0.5 < second['now'] - first['now'] < PATIENCE_S
            assert second['silent_s'] < 3

    def test_who_comes_back_misses_nothing(self, scene: Scene) -> None:
        with scene.page() as server:
            with SseClient(server.port) as reader:
                begin = reader.first('begin').data
                scene.work('WO-1')
                message = reader.first('happened')
            last = message.data['records'][-1]['seq']
            assert message.id == f'{begin["history"]}:{last}'
            scene.wait_until(lambda: scene.last_seq() > last + 30, 'more events')
            with SseClient(server.port, last_event_id=message.id) as reader:
                assert reader.first('begin').data['after'] == last
                assert reader.seqs(last + 30)[:30] == list(range(last + 1, last + 31))
            with SseClient(server.port, after=message.id) as reader:
                assert reader.seqs(last + 30)[:30] == list(range(last + 1, last + 31))

    def test_browser_gets_start_id_without_events(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            begin = reader.first('begin')
            assert begin.id == f'{begin.data["history"]}:{begin.data["after"]}'

    def test_events_unseen_by_page_come_from_node(self, scene: Scene) -> None:
        scene.work('WO-1', 'WO-2')
        with scene.page() as server, SseClient(server.port) as reader:
            history = reader.first('begin').data['history']
            reader.until(lambda event: event.kind == 'happened')
        seen = scene.last_seq()
        assert seen > 5
        with (
            scene.page() as server,  # a page that was killed, and started again
            SseClient(server.port, after=f'{history}:2') as reader,
        ):
            assert reader.first('begin').data['after'] == 2
            assert reader.seqs(seen)[: seen - 2] == list(range(3, seen + 1))

    def test_what_is_lost_for_good_is_told(self, tmp_path: Path) -> None:
        scene = Scene(tmp_path, store := Forgetful())
        scene.work('WO-1')
        with scene.page() as server:
            with SseClient(server.port) as reader:
                reader.first('begin')
                scene.wait_until(lambda: len(store.read()) > 20, 'some events')
            with SseClient(server.port, after=f'{store.history}:3') as reader:
                gap = reader.first('gap')
        last = Forgetful.KEPT_FROM - 1
        assert (gap.id, gap.data) == (f'{store.history}:{last}', {'first': 4, 'last': last})

    def test_another_history_begins_anew_for_who_is_there(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            before = reader.first('begin').data['history']
            reader.first('parts')
            with scene.cell.lock:
                scene.cell.switch()
                scene.cell.store = MemoryStore()
                scene.cell.switch()
            after = reader.first('begin').data
            assert after['history'] == scene.cell.store.history != before
            assert 'cell' in reader.first('parts').data['set'], 'everything'
            scene.work('WO-9')
            seqs = reader.seqs(after['after'] + 5)
            assert seqs[0] == after['after'] + 1

    def test_who_comes_back_with_another_history_begins_anew(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port, after='elsewhere:7') as reader:
            begin = reader.first('begin').data
            assert (begin['history'], begin['after']) == (
                scene.cell.store.history,
                scene.last_seq(),
            )

    @pytest.mark.parametrize('after', ['7', 'x:', ':7', 'x:-1', 'x:1e3', f'x:{"9" * 50}', '%00:1'])
    def test_invalid_place_starts_at_latest_event(self, scene: Scene, after: str) -> None:
        with scene.page() as server, SseClient(server.port, after=after) as reader:
            assert reader.first('begin').data['after'] == scene.last_seq()

    def test_stream_waits_for_absent_node(self, scene: Scene) -> None:
        scene.cell.switch()
        with scene.page() as server, SseClient(server.port) as reader:
            assert reader.response.status == 200
            reader.first('beat')
            reader.first('beat')
            assert reader.comments >= 2
            scene.cell.switch()
            reader.first('begin')

    def test_killed_node_falls_silent_and_returns(self, scene: Scene) -> None:
        with scene.page() as server, SseClient(server.port) as reader:
            begin = reader.first('begin').data
            scene.cell.switch()
            reader.until(lambda event: event.kind == 'beat' and event.data['silent_s'] >= 3)
            scene.cell.switch()
            scene.work('WO-1')
            first = begin['after'] + 1
            assert reader.seqs(first + 9)[:10] == list(range(first, first + 10))
            reader.until(lambda event: event.kind == 'beat' and event.data['silent_s'] < 3)

    def test_reader_beyond_limit_gets_full_message(
        self, scene: Scene, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(stream_module, 'MOST_READERS', 2)
        with scene.page() as server, ExitStack() as stack:
            for _ in range(2):
                stack.enter_context(SseClient(server.port)).first('begin')
            late = stack.enter_context(SseClient(server.port))
            assert late.response.status == 200
            message = late.next()
            assert message is not None
            assert message.kind == 'full'
            assert late.next() is None

    def test_who_leaves_is_forgotten(self, scene: Scene) -> None:
        with scene.page() as server:
            with SseClient(server.port) as reader:
                reader.first('begin')
                assert readers(server) == 1
            scene.wait_until(lambda: readers(server) == 0, 'the reader is still there')


class TestStuckReaders:
    """A reader that takes nothing costs nothing, and is sent away."""

    @pytest.fixture(autouse=True)
    def _short_limit(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(stream_module, 'SEND_LIMIT_S', 1.5)
        monkeypatch.setattr(server_module, 'SEND_LIMIT_S', 1.5)

    def test_it_goes_and_the_others_stay(self, scene: Scene) -> None:
        scene.work(*(f'WO-{number}' for number in range(20)))
        with scene.page() as server, SseClient(server.port) as good, ExitStack() as stack:
            for _ in range(5):
                stack.enter_context(stuck(server.port))
            scene.wait_until(lambda: readers(server) == 6, 'they are all there')
            begin = good.first('begin').data
            last = begin['after']

            def only_the_good_one() -> bool:
                nonlocal last
                seqs = good.seqs(0)
                assert seqs[0] == last + 1, 'it misses nothing'
                last = seqs[-1]
                return readers(server) == 1

            scene.wait_until(only_the_good_one, 'they are sent away')


class TestEnd:
    def test_the_page_ends_at_once_whoever_reads(
        self, scene: Scene, capfd: pytest.CaptureFixture[str]
    ) -> None:
        scene.work(*(f'WO-{number}' for number in range(20)))
        with ExitStack() as stack:
            with scene.page() as server:
                stack.enter_context(SseClient(server.port)).first('begin')
                stack.enter_context(stuck(server.port))
                scene.wait_until(lambda: is_one_stuck(server), 'one is stuck')
                begun = time.monotonic()
            assert time.monotonic() - begun < 2
        assert capfd.readouterr().err == ''

    def test_it_waits_for_nobody_over_tls(
        self, scene: Scene, tmp_path: Path, caplog: pytest.LogCaptureFixture
    ) -> None:
        certificate, key = make_certificate(tmp_path)
        tls = replace(access(), certificate=certificate, key=key)
        server = PageServer(WebPage(scene.cell.node.name, scene.cell.open_door, tls))
        client = ssl.create_default_context(cafile=str(certificate))
        with ExitStack() as stack, server.running():
            raw = socket.create_connection(('127.0.0.1', server.port), PATIENCE_S)
            reader = client.wrap_socket(stack.enter_context(raw), server_hostname='localhost')
            stack.enter_context(reader)
            reader.sendall(b'GET /api/stream HTTP/1.1\r\nHost: localhost\r\n\r\n')
            assert reader.recv(1)
        assert caplog.messages == []

    def test_no_thread_is_left(self, scene: Scene) -> None:
        before = set(threading.enumerate())  # a check of a password is not cut, and ends by itself
        with scene.page() as server, SseClient(server.port) as reader:
            reader.first('begin')
            assert _threads_of_page(before)
        assert not _threads_of_page(before)


def _threads_of_page(before: set[threading.Thread]) -> list[threading.Thread]:
    new = set(threading.enumerate()) - before
    return [thread for thread in new if thread.name.startswith('page: ')]


class TestServer:
    def test_it_says_how_it_is(self, scene: Scene) -> None:
        with scene.page() as server:
            scene.wait_until(lambda: get(server, '/healthz')[1]['heard'], 'the node is heard')
            status, health = get(server, '/healthz')
        assert (status, health['node'], health['readers']) == (200, '/bt_orchestrator', 0)
        assert health['silent_s'] >= 0

    def test_a_machine_gets_the_whole_status_at_once(self, scene: Scene) -> None:
        with scene.page() as server:
            scene.wait_until(lambda: get(server, '/api/cell')[0] == 200, 'the node is heard')
            scene.wait_until(lambda: get(server, '/api/cell')[1]['description'], 'a description')
            _, cell = get(server, '/api/cell')
        assert cell['node'] == '/bt_orchestrator'
        assert cell['description']['sections'] == len(cell['status']['sections']) == 5
        assert cell['status']['holds'] == [], 'what equals its default is there too'

    def test_a_port_in_use_is_a_sentence(self, scene: Scene) -> None:
        with socket.create_server(('127.0.0.1', 0)) as other:
            port = other.getsockname()[1]
            page = WebPage('/x', scene.cell.open_door, access(port=port))
            with pytest.raises(CannotListen, match=rf'port {port} of 127\.0\.0\.1 is in use'):
                PageServer(page)

    def test_an_address_of_another_computer_is_a_sentence(self, scene: Scene) -> None:
        page = WebPage('/x', scene.cell.open_door, access('192.0.2.1'))
        with pytest.raises(CannotListen, match=r'cannot listen at 192\.0\.2\.1'):
            PageServer(page)

    def test_both_doors_are_open_before_anybody_asks(self, scene: Scene) -> None:
        opened: list[str] = []

        def open_door(meanwhile: Callable[[], object]) -> Any:
            opened.append(threading.current_thread().name)
            return scene.cell.open_door(meanwhile)

        scene.cell.switch()  # there is no node: nothing is asked of it
        server = PageServer(WebPage('/x', open_door, access()))
        with server.running():
            scene.wait_until(lambda: len(opened) == 2, 'a door for questions')
        assert set(opened) == {'page: following', 'page: asking'}

    def test_silent_connection_is_closed(
        self, scene: Scene, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(server_module, 'FIRST_WITHIN_S', 0.5)
        with scene.page() as server, SseClient(server.port) as reader:
            with socket.create_connection(('127.0.0.1', server.port), PATIENCE_S) as silent:
                silent.sendall(b'GET / HTTP/1.1\r\nHost: ')
                with suppress(ConnectionResetError):
                    assert silent.recv(1) == b''
            assert reader.first('beat').kind == 'beat', 'who has asked for something stays'

    def test_a_connection_that_has_ended_is_forgotten(
        self, scene: Scene, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(server_module, 'FIRST_WITHIN_S', 1000.0)

        def connections() -> int:
            gc.collect()
            return sum(isinstance(item, server_module.Protocol) for item in gc.get_objects())

        with scene.page() as server:
            for _ in range(20):
                get(server, '/healthz')
            scene.wait_until(lambda: connections() <= 2, 'connections are still there')

    def test_files_are_asked_for_again_after_an_update(self, scene: Scene) -> None:
        with scene.page() as server:
            connection = http.client.HTTPConnection('127.0.0.1', server.port)
            connection.request('GET', '/static/index.html')
            response = connection.getresponse()
            assert response.status == 200
            assert response.headers['cache-control'] == 'no-cache'
            connection.close()

    def test_fatal_error_is_raised_to_starter(self) -> None:
        def no_door(meanwhile: Callable[[], object]) -> Any:
            raise RuntimeError('there is no network')

        server = PageServer(WebPage('/x', no_door, access()))
        with server.running(), pytest.raises(RuntimeError, match='there is no network'):
            server.wait()


@contextmanager
def stuck(port: int) -> Iterator[None]:
    """Open a stream, and never read from it."""
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.connect(('127.0.0.1', port))
        connection.sendall(b'GET /api/stream HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n')
        yield


def is_one_stuck(server: PageServer) -> bool:
    """Tell whether a reader has taken nothing for a while."""
    return any(reader.is_stuck(0.5) for reader in list(server._page.streams.readers))
