"""Endpoints about whoever asks: login, logout, lock, and what they may do."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem, body_of
from bt_orchestrator.extensions.page.web.people import Caller, People, Session
from bt_orchestrator.model.limits import WHO
from bt_orchestrator.model.requests import TABLE
from bt_orchestrator.script.users.file import UsersUnusable
from bt_orchestrator.script.users.logins import LoginRefused, MustWait
from bt_orchestrator.script.users.passwords import LONGEST

LANGUAGES = ('en', 'de')
"""Of the texts of the page (`static/strings`)."""

_PASSWORD = {'type': 'string', 'maxLength': LONGEST}
_REFUSED = {
    401: 'no user has this name and password',
    429: 'too many attempts; `wait_s` says how long to wait',
}


def endpoints(people: People) -> Sequence[Endpoint]:
    """Return the endpoints."""
    me = _Me(people)
    return (
        Endpoint('GET', '/api/me', me.tell, 'who asks, and what that role may do'),
        Endpoint(
            'POST', '/api/login', me.log_in, 'begins a session, whose id is in a cookie',
            body={'name': {'type': 'string', 'maxLength': WHO}, 'password': _PASSWORD},
            required=('name', 'password'), refusals=_REFUSED,
        ),
        Endpoint('POST', '/api/logout', me.log_out, 'ends the session'),
        Endpoint('POST', '/api/lock', me.lock, 'locks the session; abort, pause and stop go on'),
        Endpoint(
            'POST', '/api/unlock', me.unlock, 'unlocks the session',
            body={'password': _PASSWORD}, required=('password',), refusals=_REFUSED,
        ),
        Endpoint(
            'POST', '/api/active', me.tell, 'keeps the session from locking: somebody is there'
        ),
    )  # fmt: skip


class _Me:
    def __init__(self, people: People) -> None:
        self._people = people
        self._access = people.access

    async def tell(self, request: Request) -> Response:
        return self._told(request.state.caller)

    async def log_in(self, request: Request) -> Response:
        if self._access.proxy_header:
            raise Problem(403, 'the proxy of this page logs people in; there is no other login')
        body = await body_of(request)
        name, password = _text(body, 'name'), _text(body, 'password')
        caller: Caller = request.state.caller
        try:
            key = await self._people.log_in(caller, name, password)
        except (LoginRefused, MustWait, UsersUnusable) as error:
            raise _problem_of(error) from error
        response = self._told(Caller(caller.address, key))
        response.set_cookie(
            self._access.cookie,
            key,
            path='/',
            secure=self._access.has_tls,
            httponly=True,
            samesite='strict',
        )
        return response

    async def log_out(self, request: Request) -> Response:
        self._people.log_out(request.state.caller)
        response = self._told(Caller(request.state.caller.address))
        response.delete_cookie(
            self._access.cookie,
            path='/',
            secure=self._access.has_tls,
            httponly=True,
            samesite='strict',
        )
        return response

    async def lock(self, request: Request) -> Response:
        self._people.lock(request.state.caller)
        return self._told(request.state.caller)

    async def unlock(self, request: Request) -> Response:
        password = _text(await body_of(request), 'password')
        try:
            await self._people.unlock(request.state.caller, password)
        except (LoginRefused, MustWait, UsersUnusable) as error:
            raise _problem_of(error) from error
        return self._told(request.state.caller)

    def _told(self, caller: Caller) -> Response:
        session = self._people.who(caller)
        return Json(
            {
                **_about(session),
                'may': {request.name: _may(session, request.roles) for request in TABLE},
                'locks_after_s': self._access.idle_s,
                'looks_freely': self._access.looks_freely,
                'can_log_in': not self._access.proxy_header,
                'languages': LANGUAGES,
            }
        )


def _about(session: Session | None) -> dict[str, Any]:
    if session is None:
        return {
            'name': '',
            'role': '',
            'how': '',
            'is_locked': False,
            'is_panel': False,
            'ends': None,
            'idle_s': None,
        }
    left_s = session.left_s
    return {
        'name': session.name,
        'role': session.role.value,
        'how': session.how.value,
        'is_locked': session.is_locked,
        'is_panel': session.is_panel,
        'ends': None if left_s is None else round(time.time() + left_s),
        'idle_s': session.idle_left_s,
    }


def _may(session: Session | None, roles: frozenset[Any]) -> bool:
    return session is not None and session.role in roles


def _text(body: dict[str, Any], name: str) -> str:
    value = body.get(name)
    if not isinstance(value, str):
        raise Problem(422, f'{name} is a text')
    return value


def _problem_of(error: LoginRefused | MustWait | UsersUnusable) -> Problem:
    if isinstance(error, MustWait):
        return Problem(429, str(error), wait_s=error.wait_s)
    if isinstance(error, UsersUnusable):
        return Problem(503, str(error))
    return Problem(401, str(error), why='login')
