"""An endpoint of the API, as its route, the docs and OpenAPI need it; and its answers."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.codec import json_of

Schema = Mapping[str, Any]
"""A JSON Schema."""


@dataclass(frozen=True)
class Endpoint:
    """One path with one method."""

    method: str
    """GET or POST."""
    path: str
    """As Starlette writes it, for instance /api/items/{item:path}."""
    answer: Callable[..., Awaitable[Response | None]]
    """Takes a request; or an object that is an ASGI application."""
    does: str
    """One sentence without a full stop, for whoever writes a client."""
    query: Mapping[str, str] = field(default_factory=dict)
    """Parameters of the query, each with its meaning; all may be left out."""
    body: Mapping[str, Schema] = field(default_factory=dict)
    """Members of the JSON object that a POST takes."""
    required: tuple[str, ...] = ()
    """Members that must be there."""
    refusals: Mapping[int, str] = field(default_factory=dict)
    """Statuses of its own besides 200, each with its meaning."""
    media: str = 'application/json'
    """Type of the answer."""

    def route(self) -> Route:
        """Return its route."""
        return Route(self.path, self.answer, methods=[self.method])


def routes(endpoints: Iterable[Endpoint]) -> list[Route]:
    """Return their routes, in their order: the first that fits a path answers."""
    return [endpoint.route() for endpoint in endpoints]


# Answers of the API: JSON only, errors as a sentence.


class Json(Response):
    """Strict JSON."""

    media_type = 'application/json'

    def render(self, content: Any) -> bytes:
        """Return a value as bytes; half of a surrogate pair is escaped."""
        return json_of(content).encode()


class Problem(Exception):
    """A mistake in a request, as its answer."""

    def __init__(self, status: int, message: str, **more: object) -> None:
        """Say what was expected.

        :param more: other members of the answer
        """
        super().__init__(message)
        self.status = status
        self.more = more

    def response(self) -> Response:
        """Return the answer."""
        wait_s = self.more.get('wait_s')
        headers = None if wait_s is None else {'retry-after': str(wait_s)}
        words = {'message': str(self), 'said': said_in_each(str(self))}
        return Json({**words, **self.more}, self.status, headers=headers)


def attached(name: str) -> dict[str, str]:
    """Return the headers of a file to keep; a document has a style of its own, as no page may."""
    named = quote(name, safe='')
    return {'content-disposition': f"attachment; filename*=UTF-8''{named}"}


def language_of(request: Request, known: Collection[str], otherwise: str) -> str:
    """Return the language that a request asks for.

    :param otherwise: if it asks for none
    :raises Problem: there are no words in this language
    """
    language = request.query_params.get('language')
    if language is None:
        return otherwise
    if language not in known:
        raise Problem(422, f'language is {" or ".join(known)}; found {language!r}')
    return language


async def _of_http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    message = _WORDS.get(error.status_code, error.detail)
    return Problem(error.status_code, f'{request.method} {request.url.path}: {message}').response()


_WORDS: Mapping[int, str] = {
    404: 'there is no such thing here',
    405: 'this is asked with another method',
}

HANDLERS: Mapping[Any, Any] = {HTTPException: _of_http}
"""For the application: errors that no guard sees as they are raised."""

BODY_S = 10.0
"""Longest time for a body to come."""

BODY_DEPTH = 32
"""Most lists and objects within each other."""

BODY_BYTES = 1_000_000
"""Longest body of a request, as `model.limits.REQUEST_BYTES`."""


async def body_of(request: Request) -> dict[str, Any]:
    """Return the JSON object in a request.

    :raises Problem: there is none, or it is too long
    """
    try:
        text = await asyncio.wait_for(_read(request), BODY_S)
    except asyncio.TimeoutError as error:
        raise Problem(408, f'the request did not come within {BODY_S:g} s') from error
    try:
        body = json.loads(text or b'{}', parse_constant=_refused)
        _check(body, BODY_DEPTH)
    except (ValueError, RecursionError) as error:
        raise Problem(422, f'the body of the request cannot be used: {error}') from error
    if not isinstance(body, dict):
        raise Problem(422, f'the body is a JSON object; found {body!r:.100}')
    return body


async def _read(request: Request) -> bytes:
    text = bytearray()
    async for piece in request.stream():
        text += piece
        if len(text) > BODY_BYTES:
            raise Problem(413, f'a request has at most {BODY_BYTES} bytes')
    return bytes(text)


def _refused(word: str) -> None:
    raise ValueError(f'{word} is no number of JSON')


def _check(value: Any, depth: int) -> None:
    """Refuse what neither ROS nor a journal can carry.

    :raises ValueError: says what it is
    """
    if not depth:
        raise ValueError(f'lists and objects are at most {BODY_DEPTH} deep in each other')
    if isinstance(value, str):
        value.encode()  # UnicodeEncodeError is a ValueError: half of a surrogate pair
        if '\0' in value:
            raise ValueError('a text has the character NUL')
    elif isinstance(value, dict):
        for member in (*value, *value.values()):
            _check(member, depth - 1)
    elif isinstance(value, list):
        for member in value:
            _check(member, depth - 1)
