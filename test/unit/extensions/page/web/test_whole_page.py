"""The page with all its endpoints: what describes them, and that none is beside the guards."""

from __future__ import annotations

import asyncio
import http.client
import json
import re
import ssl
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from fakes.browser import Browser
from fakes.certificates import make_certificate
from fakes.quick_users import PASSWORD, write_users
from patience import PATIENCE_S
from starlette.applications import Starlette
from starlette.routing import Mount, Route
from web.stand_cell import StandCell

from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.app import OPENAPI_PATH, endpoints_of, make_app
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.extensions.page.web.guards import FREE_PATHS
from bt_orchestrator.extensions.page.web.page import WebPage
from bt_orchestrator.extensions.page.web.request_paths import ANY
from bt_orchestrator.extensions.page.web.server import PageServer
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.requests import TABLE
from bt_orchestrator.store.memory import MemoryStore

NEEDED = {
    'position': 1,
    'orders': [{'script': 'small'}],
    'queue_digest': 'd1ge57',
    'jobs': ['WO-1'],
    'code': 'JAM',
    'task': 'TASK_A',
}
"""Arguments that a request cannot do without."""
ADDRESS = '10.0.0.1'


class Whole:
    """A page that was started, without a server."""

    def __init__(self, folder: Path) -> None:
        self.cell = StandCell(folder, MemoryStore(), faults=[])
        users = write_users(folder / 'users.yaml', {'eve': Role.ENGINEER})
        access = Access(users, ADDRESS, certificate=folder, key=folder)
        self.page = WebPage(self.cell.node.name, self.cell.open_door, access)
        self.loop = asyncio.new_event_loop()
        self.loop.run_until_complete(self._start())

    async def _start(self) -> None:
        self.page.start(lambda: None)
        self.app: Starlette = make_app(self.page)

    def browser(self) -> Browser:
        return Browser(self.app, self.loop, host=ADDRESS, scheme='https')

    @property
    def endpoints(self) -> list[Endpoint]:
        return endpoints_of(self.page)

    def wait_until_heard(self) -> None:
        """Wait until the page has heard of its cell: until then it answers 503."""
        browser, deadline = self.browser(), time.monotonic() + PATIENCE_S
        browser.post('/api/login', {'name': 'eve', 'password': PASSWORD})
        while browser.get('/api/cell').status == 503:
            assert time.monotonic() < deadline, 'nothing was heard of the cell'
            self.loop.run_until_complete(asyncio.sleep(0.01))

    def close(self) -> None:
        async def end() -> None:
            self.page.end()
            await asyncio.sleep(0)

        self.loop.run_until_complete(end())
        self.page.join()
        self.loop.close()


@pytest.fixture(scope='module')
def whole(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Whole]:
    made = Whole(tmp_path_factory.mktemp('whole'))
    made.wait_until_heard()
    yield made
    made.close()


@pytest.fixture(scope='module')
def document(whole: Whole) -> Any:
    browser = whole.browser()
    assert browser.post('/api/login', {'name': 'eve', 'password': PASSWORD}).status == 200
    return browser.get(OPENAPI_PATH).json


def filled(path: str) -> str:
    """Return a path with something in each of its parts."""
    return re.sub(r'{\w+(:\w+)?}', 'x', path)


def test_every_route_is_described_and_nothing_else(whole: Whole, document: Any) -> None:
    described = {
        (method.upper(), path)
        for path, operations in document['paths'].items()
        for method in operations
    }
    routed = set()
    for route in whole.app.routes:
        if isinstance(route, Mount):
            assert route.path == '/static'
            continue
        assert isinstance(route, Route)
        methods = (route.methods or set()) - {'HEAD'}
        routed |= {(method, re.sub(r':\w+}', '}', route.path)) for method in methods}
    assert routed == described | {('GET', '/')}


def test_the_description_holds_together(document: Any) -> None:
    assert document['openapi'] == '3.1.0'
    operations = [entry for path in document['paths'].values() for entry in path.values()]
    names = [entry['operationId'] for entry in operations]
    assert len(set(names)) == len(names)
    for path, methods in document['paths'].items():
        for operation in methods.values():
            named = {entry['name'] for entry in operation['parameters'] if entry['in'] == 'path'}
            assert named == set(re.findall(r'{(\w+)}', path))
            assert operation['summary']
            assert not operation['summary'].endswith('.')


def test_request_bodies_fit_their_json_schemas(document: Any) -> None:
    schemas = {
        path: methods['post']['requestBody']['content']['application/json']['schema']
        for path, methods in document['paths'].items()
        if 'post' in methods
    }
    for schema in schemas.values():
        jsonschema.Draft202012Validator.check_schema(schema)
        assert set(schema['required']) <= schema['properties'].keys()
    for request in TABLE:
        schema = schemas[ANY]
        body = {request.subject.name: 'x'} if request.subject is not None else {}
        needed = {
            parameter.name: NEEDED[parameter.name]
            for parameter in request.parameters
            if parameter.is_required and parameter.name not in body
        }
        jsonschema.validate({**body, **needed, 'reason': 'r', 'ticket': '0' * 16}, schema)
        offered = {parameter.name for parameter in request.parameters}
        assert offered <= schema['properties'].keys(), request.name


def test_exposed_page_refuses_all_access_without_login(whole: Whole) -> None:
    for endpoint in whole.endpoints:
        if endpoint.path in FREE_PATHS:
            continue
        browser = whole.browser()
        path = filled(endpoint.path)
        answer = browser.get(path) if endpoint.method == 'GET' else browser.post(path)
        assert (answer.status, answer.json['why']) == (401, 'login'), endpoint.path


def test_what_is_free_is_what_a_login_needs(whole: Whole) -> None:
    assert {'/', '/favicon.ico', '/healthz', '/api/me', '/api/login'} == FREE_PATHS
    assert whole.browser().get('/').status == 200
    assert whole.browser().get('/healthz').json['node'] == whole.page.doors.name
    assert whole.browser().get('/static/index.html').status == 200
    assert whole.browser().get('/static/../app.py').status == 404


def test_no_endpoint_falls_over_strange_input(whole: Whole) -> None:
    """Each answers with a sentence; a server error would be one with a traceback in the log."""
    browser = whole.browser()
    browser.post('/api/login', {'name': 'eve', 'password': PASSWORD})
    strange = ('', 'x', '-1', '%00', '9' * 30, '%2e%2e%2f', '%F0%9F%A4%96', "'%22<>")
    for endpoint in whole.endpoints:
        if endpoint.path in ('/api/stream', '/api/logout') or endpoint.method == 'POST':
            continue
        for text in strange:
            query = '&'.join(f'{name}={text}' for name in endpoint.query)
            path = re.sub(r'{\w+(:\w+)?}', text or 'y', endpoint.path)
            answer = browser.get(f'{path}?{query}')
            assert answer.status < 500, (path, query, answer.body)


# --- over TLS -----------------------------------------------------------------------------------


def test_page_serves_tls_with_its_own_certificate(tmp_path: Path) -> None:
    certificate, key = make_certificate(tmp_path)
    users = write_users(tmp_path / 'users.yaml', {'ann': Role.OPERATE})
    cell = StandCell(tmp_path, MemoryStore(), faults=[])
    access = Access(users, '127.0.0.1', 0, certificate, key)
    access.check()
    server = PageServer(WebPage(cell.node.name, cell.open_door, access))
    assert server.address.startswith('https://127.0.0.1:')
    trusting = ssl.create_default_context(cafile=str(certificate))
    with server.running():
        connection = http.client.HTTPSConnection(
            '127.0.0.1', server.port, timeout=PATIENCE_S, context=trusting
        )
        origin = f'https://127.0.0.1:{server.port}'
        headers = {'Origin': origin, 'Content-Type': 'application/json'}
        login = json.dumps({'name': 'ann', 'password': PASSWORD})
        connection.request('POST', '/api/login', login, headers)
        answer = connection.getresponse()
        assert answer.status == 200, answer.read()
        assert 'Secure' in answer.headers['set-cookie']
        answer.read()
        connection.close()


# --- while a stream is open ---------------------------------------------------------------------


def test_stream_ends_when_its_user_is_removed(tmp_path: Path) -> None:
    users = write_users(tmp_path / 'users.yaml', {'ann': Role.VIEW, 'eve': Role.VIEW})
    cell = StandCell(tmp_path, MemoryStore(), faults=[])
    access = Access(users, '127.0.0.1', 0, proxy_header='X-User')
    server = PageServer(WebPage(cell.node.name, cell.open_door, access))
    with server.running(), ExitStack() as stack:
        streams = {}
        for name in ('ann', 'eve'):
            connection = http.client.HTTPConnection('127.0.0.1', server.port, timeout=PATIENCE_S)
            stack.callback(connection.close)
            connection.request('GET', '/api/stream', headers={'X-User': name})
            streams[name] = stack.enter_context(connection.getresponse())
            assert streams[name].status == 200
        write_users(users, {'eve': Role.VIEW})
        with pytest.raises((http.client.IncompleteRead, ConnectionError, ValueError)):
            streams['ann'].read()  # the connection ends within a message
        assert streams['eve'].read(1) == b':'
