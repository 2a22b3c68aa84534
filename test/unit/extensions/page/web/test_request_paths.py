"""Which request was posted, under its own path and under those of earlier versions."""

from __future__ import annotations

import pytest
from starlette.routing import Match, Route

from bt_orchestrator.extensions.page.web.request_paths import PLACES, request_at
from bt_orchestrator.model.requests import REQUESTS, TABLE, BadArguments, Request

EARLIER = {
    'cell.reset': ('/api/cell/reset', {}),
    'cell.start': ('/api/cell/start', {}),
    'cell.pause': ('/api/cell/pause', {}),
    'cell.resume': ('/api/cell/resume', {}),
    'cell.stop': ('/api/cell/stop', {}),
    'cell.abort': ('/api/cell/abort', {}),
    'cell.clear': ('/api/cell/clear', {}),
    'cell.stop_after_item': ('/api/queue/stop_after', {'after': 'item'}),
    'cell.stop_after_job': ('/api/queue/stop_after', {'after': 'job'}),
    'cell.stop_after_never': ('/api/queue/stop_after', {'after': 'never'}),
    'queue.add': ('/api/queue/add', {}),
    'job.move': ('/api/queue/move', {}),
    'job.next': ('/api/queue/move', {'next': True}),
    'job.release': ('/api/queue/command', {'command': 'release'}),
    'job.hold': ('/api/queue/command', {'command': 'hold'}),
    'job.update': ('/api/queue/update', {}),
    'job.pause': ('/api/queue/command', {'command': 'pause'}),
    'job.resume': ('/api/queue/command', {'command': 'resume'}),
    'job.stop': ('/api/queue/command', {'command': 'stop'}),
    'job.requeue': ('/api/queue/command', {'command': 'requeue'}),
    'job.abort': ('/api/queue/command', {'command': 'abort'}),
    'job.cancel': ('/api/queue/command', {'command': 'remove'}),
    'job.clear': ('/api/queue/command', {'command': 'clear'}),
    'item.remove_item': ('/api/items/WO 1/3/remove', {'item': 'WO 1/3'}),
    'hold.retry': ('/api/holds/7/answer', {'hold': '7', 'answer': 'retry'}),
    'hold.again': ('/api/holds/7/answer', {'hold': '7', 'answer': 'again'}),
    'hold.mark_done': ('/api/holds/7/answer', {'hold': '7', 'answer': 'mark_done'}),
    'hold.skip': ('/api/holds/7/answer', {'hold': '7', 'answer': 'skip'}),
    'hold.reject': ('/api/holds/7/answer', {'hold': '7', 'answer': 'reject'}),
    'hold.abort_job': ('/api/holds/7/answer', {'hold': '7', 'answer': 'abort_job'}),
    'hold.acknowledge': ('/api/holds/7/answer', {'hold': '7', 'answer': 'acknowledge'}),
    'hold.comment': ('/api/holds/7/answer', {'hold': '7', 'answer': 'comment'}),
    'component.out_of_service': ('/api/components/arm/service', {'command': 'out_of_service'}),
    'component.in_service': ('/api/components/arm/service', {'command': 'in_service'}),
    'script.release_script': ('/api/scripts/ab12/release', {'script': 'ab12'}),
}
"""Paths of earlier versions, which programs of today post to."""


def read(path: str, body: dict[str, object]) -> tuple[Request, dict[str, object]]:
    """Read a request as the routes do."""
    scope = {'type': 'http', 'method': 'GET', 'path': path, 'headers': []}
    for pattern in PLACES:
        match, child_scope = Route(pattern, lambda _: None).matches(scope)
        if match is not Match.NONE:
            given = {**body, **child_scope['path_params']}
            return request_at(pattern, given), given
    raise AssertionError(f'no route has the path {path}')


@pytest.mark.parametrize(('name', 'posted'), EARLIER.items(), ids=EARLIER)
def test_paths_of_earlier_versions_stay(name: str, posted: tuple[str, dict[str, object]]) -> None:
    path, body = posted
    subject: dict[str, object] = {
        key: body[key] for key in ('hold', 'item', 'script') if key in body
    }
    subject |= {'component': 'arm'} if 'components' in path else {}
    request, given = read(path, body)
    assert request is REQUESTS[name]
    assert given == subject


@pytest.mark.parametrize('request_', TABLE, ids=lambda entry: entry.name)
def test_every_request_has_a_path_of_its_own(request_: Request) -> None:
    request, given = read(f'/api/requests/{request_.name}', {'job': 'WO-2'})
    assert (request, given) == (request_, {'job': 'WO-2'})


@pytest.mark.parametrize(
    ('path', 'body', 'message'),
    [
        ('/api/cell/explode', {}, "command is one of reset, start, .*; found 'explode'"),
        ('/api/holds/3/answer', {'answer': 'pray'}, "answer is one of retry, .*; found 'pray'"),
        ('/api/holds/3/answer', {}, 'answer is one of retry, .*; found None'),
        ('/api/queue/command', {'job': 'WO-1', 'command': ['stop']}, r"; found \['stop'\]"),
        (
            '/api/queue/stop_after',
            {'after': 'lunch'},
            "after is one of item, job, never; found 'lu",
        ),
        (
            '/api/queue/move',
            {'job': 'WO-1', 'next': 1},
            'next is one of true, false, null; found 1',
        ),
        ('/api/requests/cell.fly', {}, "name is one of cell.reset, .*; found 'cell.fly'"),
    ],
)
def test_what_is_no_request(path: str, body: dict[str, object], message: str) -> None:
    with pytest.raises(BadArguments, match=message):
        read(path, body)
