"""Where each request of the table is posted, and what stands in the body.

`ANY` takes each request by its name. The others are used in both directions: offers say where to
post, and the routes of commands read it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple
from urllib.parse import quote

from bt_orchestrator.model.requests import (
    ADD,
    CELL,
    MOVE,
    NEXT,
    RELEASE_SCRIPT,
    REMOVE_ITEM,
    REQUESTS,
    STOP_AFTERS,
    UPDATE,
    About,
    Request,
    of_word,
)
from bt_orchestrator.model.wish import STOP_AFTER

ANY = '/api/requests/{name}'
ANSWER = '/api/holds/{hold}/answer'
CELL_COMMAND = '/api/cell/{command}'
ITEM = '/api/items/{item:path}/remove'
COMPONENT = '/api/components/{component:path}/service'
SCRIPT = '/api/scripts/{script:path}/release'
QUEUE_ADD = '/api/queue/add'
QUEUE_MOVE = '/api/queue/move'
QUEUE_UPDATE = '/api/queue/update'
QUEUE_COMMAND = '/api/queue/command'
QUEUE_STOP_AFTER = '/api/queue/stop_after'


class Place(NamedTuple):
    """Where a request is posted."""

    path: str
    body: Mapping[str, object]
    """What stands in the body beside the parameters of the request, reason and ticket."""


def place_of(request: Request, subject: str = '') -> Place:
    """Return where a request is posted.

    :param subject: id of its job, item, hold, component or script; empty: it has none
    """
    path = (
        pattern_of(request)
        .replace('{hold}', quote(subject, safe=''))
        .replace('{item:path}', quote(subject))
        .replace('{component:path}', quote(subject))
        .replace('{script:path}', quote(subject))
        .replace('{command}', request.word)
    )
    return Place(
        path, {**({'job': subject} if request.about is About.JOB else {}), **_says(request)}
    )


def pattern_of(request: Request) -> str:
    """Return the path of a request with the names of its parts, as routes write it."""
    match request.about:
        case About.HOLD:
            return ANSWER
        case About.ITEM:
            return ITEM
        case About.COMPONENT:
            return COMPONENT
        case About.SCRIPT:
            return SCRIPT
        case About.QUEUE:
            return QUEUE_ADD
        case About.JOB:
            return {MOVE.name: QUEUE_MOVE, NEXT.name: QUEUE_MOVE, UPDATE.name: QUEUE_UPDATE}.get(
                request.name, QUEUE_COMMAND
            )
        case About.CELL:
            return QUEUE_STOP_AFTER if request in STOP_AFTERS.values() else CELL_COMMAND


def _says(request: Request) -> Mapping[str, object]:
    """Return what tells a request from the others with its path."""
    match pattern_of(request):
        case path if path == ANSWER:
            return {'answer': request.word}
        case path if path in (QUEUE_COMMAND, COMPONENT):
            return {'command': request.word}
        case path if path == QUEUE_STOP_AFTER:
            return {'after': request.word.removeprefix(STOP_AFTER)}
    return {'next': True} if request == NEXT else {}


# --- back ---------------------------------------------------------------------------------------

Found = tuple[Request, Mapping[str, object]]
"""A request, and what is in its arguments already."""


class NoSuchRequest(ValueError):
    """No request has this path and body; the message says what was expected."""


def any_request(name: str, _: dict[str, object]) -> Found:
    """Return the request of a name; all of its arguments stand in the body."""
    request = REQUESTS.get(name)
    if request is None:
        raise NoSuchRequest(f'there is no request {name!r:.60}; one of {", ".join(REQUESTS)}')
    return request, {}


def answer_to_hold(hold: str, body: dict[str, object]) -> Found:
    """Return the request of an answer to a hold; takes what it reads out of the body."""
    return _of_word(About.HOLD, body.pop('answer', None), 'answer'), {'hold': hold}


def to_cell(command: str, _: dict[str, object]) -> Found:
    """Return the request of a command to the cell."""
    request = of_word(About.CELL, command)
    if request is None or request not in CELL.values():
        words = ', '.join(one.word for one in CELL.values())
        raise NoSuchRequest(f'there is no command {command!r} to the cell; one of {words}')
    return request, {}


def remove_item(item: str, _: dict[str, object]) -> Found:
    """Return the request that removes an item."""
    return REMOVE_ITEM, {'item': item}


def to_component(component: str, body: dict[str, object]) -> Found:
    """Return the request of a command to a component."""
    request = _of_word(About.COMPONENT, body.pop('command', None), 'command')
    return request, {'component': component}


def release_script(script: str, _: dict[str, object]) -> Found:
    """Return the request that releases a script."""
    return RELEASE_SCRIPT, {'script': script}


def add_orders(_: str, __: dict[str, object]) -> Found:
    """Return the request that queues orders."""
    return ADD, {}


def move_job(_: str, body: dict[str, object]) -> Found:
    """Return the request that gives a job another place; `next: true`: the first one."""
    is_next = body.pop('next', False)
    if not isinstance(is_next, bool):
        raise NoSuchRequest(f'next is true or false; found {is_next!r}')
    return (NEXT if is_next else MOVE), {}


def update_job(_: str, __: dict[str, object]) -> Found:
    """Return the request that changes a queued job."""
    return UPDATE, {}


def command_job(_: str, body: dict[str, object]) -> Found:
    """Return the request of a command to a job."""
    return _of_word(About.JOB, body.pop('command', None), 'command'), {}


def stop_after(_: str, body: dict[str, object]) -> Found:
    """Return the request that the cell stops after an item or a job, or does not."""
    after = body.pop('after', None)
    request = STOP_AFTERS.get(after) if isinstance(after, str) else None
    if request is None:
        raise NoSuchRequest(f'after is one of {", ".join(STOP_AFTERS)}; found {after!r}')
    return request, {}


def _of_word(about: About, word: object, key: str) -> Request:
    request = of_word(about, word) if isinstance(word, str) else None
    if request is None:
        raise NoSuchRequest(
            f'no {key} to a {about.value} is {word!r}; GET /api/openapi.json has all'
        )
    return request


READERS: Mapping[str, Callable[[str, dict[str, object]], Found]] = {
    ANY: any_request,
    ANSWER: answer_to_hold,
    CELL_COMMAND: to_cell,
    ITEM: remove_item,
    COMPONENT: to_component,
    SCRIPT: release_script,
    QUEUE_ADD: add_orders,
    QUEUE_MOVE: move_job,
    QUEUE_UPDATE: update_job,
    QUEUE_COMMAND: command_job,
    QUEUE_STOP_AFTER: stop_after,
}
"""By path: which request is meant, by what the path names and the body.

:raises NoSuchRequest: none
"""
