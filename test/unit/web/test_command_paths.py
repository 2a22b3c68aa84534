"""Where requests are posted, and which request it is that was posted."""

from __future__ import annotations

import pytest
from starlette.routing import Match, Route

from bt_orchestrator.model.requests import TABLE, Request
from bt_orchestrator.web.command_paths import READERS, Found, NoSuchRequest, place_of

SUBJECTS = {'job': 'WO-2', 'item': 'WO 1/3', 'hold': 'h/7'}


def read_back(path: str, body: dict[str, object]) -> Found:
    """Read a request as the routes do."""
    scope = {'type': 'http', 'method': 'GET', 'path': path.replace('%20', ' '), 'headers': []}
    for pattern, reader in READERS.items():
        match, found = Route(pattern, lambda _: None).matches(scope)
        if match is not Match.NONE:
            return reader(next(iter(found['path_params'].values()), ''), body)
    raise AssertionError(f'no route has the path {path}')


@pytest.mark.parametrize('request_', TABLE, ids=lambda one: one.name)
def test_every_request_has_a_place_of_its_own(request_: Request) -> None:
    subject = SUBJECTS.get(request_.about.value, '')
    path, body = place_of(request_, subject.replace('h/7', 'h7'))
    rest = dict(body)
    found, given = read_back(path, rest)
    assert found == request_
    if request_.subject is not None:
        known = {**given, **rest}
        assert known[request_.subject.name] == subject.replace('h/7', 'h7')


def test_a_place_tells_requests_apart() -> None:
    places = [(place_of(one, 'x').path, str(place_of(one, 'x').body)) for one in TABLE]
    assert len(set(places)) == len(TABLE)


def test_ids_cannot_leave_their_part_of_the_path() -> None:
    hold = next(one for one in TABLE if one.about.value == 'hold')
    assert place_of(hold, '../cell/abort?x').path == '/api/holds/..%2Fcell%2Fabort%3Fx/answer'


@pytest.mark.parametrize(
    ('path', 'body', 'message'),
    [
        ('/api/cell/explode', {}, "no command 'explode' to the cell; one of reset, start"),
        ('/api/holds/3/answer', {'answer': 'pray'}, "no answer to a hold is 'pray'"),
        ('/api/holds/3/answer', {}, 'no answer to a hold is None'),
        ('/api/queue/command', {'job': 'WO-1', 'command': ['stop']}, 'no command to a job is'),
        (
            '/api/queue/stop_after',
            {'after': 'lunch'},
            "after is one of item, job, never; found 'lu",
        ),
        ('/api/queue/move', {'job': 'WO-1', 'next': 1}, 'next is true or false; found 1'),
    ],
)
def test_what_is_no_request(path: str, body: dict[str, object], message: str) -> None:
    with pytest.raises(NoSuchRequest, match=message):
        read_back(path, body)
