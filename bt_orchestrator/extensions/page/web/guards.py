"""The guards of every request before its route, and of every answer before a browser."""

from __future__ import annotations

import logging

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from bt_orchestrator.extensions.page.web.access import Access
from bt_orchestrator.extensions.page.web.endpoint import Problem
from bt_orchestrator.extensions.page.web.people import Caller, People

log = logging.getLogger(__name__)

FREE_PATHS = frozenset({'/', '/favicon.ico', '/healthz', '/api/me', '/api/login'})
FREE_FOLDER = '/static/'
"""The files for the login, and the path for a monitor to see that the page is there."""

HEADERS = {
    'content-security-policy': (
        "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'; "
        "object-src 'none'"
    ),
    'cross-origin-opener-policy': 'same-origin',
    'cross-origin-resource-policy': 'same-origin',
    'referrer-policy': 'no-referrer',
    'x-content-type-options': 'nosniff',
    'x-frame-options': 'DENY',
}

_LOOKING = ('GET', 'HEAD')


class GuardMiddleware:
    """Refuses what comes from elsewhere, and says who is asking: `request.state.session`.

    `state.caller` is what is known of the request itself, `state.may_look()` whether its sender
    may go on to look, for answers that take long.
    """

    def __init__(self, app: ASGIApp, people: People) -> None:
        self._app = app
        self._access = people.access
        self._people = people

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it."""
        if scope['type'] != 'http':
            await self._app(scope, receive, send)
            return
        answering = _Answering(scope, send)
        try:
            self._check(scope)
            await self._app(scope, receive, answering.send)
        except Problem as refused:
            await refused.response()(scope, receive, answering.send)
        except ClientDisconnect:
            log.info('whoever sent %s %s has left', scope['method'], scope['path'])
        except Exception:
            log.exception('error in %s %s', scope['method'], scope['path'])
            if answering.has_begun:
                raise
            response = Problem(500, 'the page has an error, which is in its log').response()
            await response(scope, receive, answering.send)

    def _check(self, scope: Scope) -> None:
        """Refuse a request that cannot come from here, and note its sender.

        :raises Problem: says what was expected
        """
        headers = Headers(scope=scope)
        host = headers.get('host', '')
        if not self._access.is_allowed_host(_name_in(host)):
            raise Problem(
                403,
                f'this page does not answer as {host or "a host without a name"}; if its computer '
                'has that name, start it with --allow-host NAME',
            )
        if scope['method'] not in _LOOKING:
            _check_origin(headers, host, scope['scheme'], self._access)
            _check_content(headers)
        caller = _caller(scope, headers, self._access)
        if scope['method'] not in _LOOKING:
            self._people.use(caller)
        session = self._people.who(caller)
        state = scope.setdefault('state', {})
        state['caller'], state['session'] = caller, session
        state['may_look'] = lambda: self._people.may_look(caller)
        if session is None and not self._is_free(scope):
            raise Problem(401, self._who_are_you(caller), why='login')

    def _is_free(self, scope: Scope) -> bool:
        path = scope['path']
        if path in FREE_PATHS or path.startswith(FREE_FOLDER):
            return True
        return self._access.looks_freely and scope['method'] in _LOOKING

    def _who_are_you(self, caller: Caller) -> str:
        if not self._access.proxy_header:
            return 'log in first'
        if not self._access.is_proxy(caller.address):
            return f'{caller.address} is not the proxy of this page; go through the proxy'
        if not caller.proxied:
            return f'the proxy named no user in {self._access.proxy_header}'
        return (
            f'{caller.proxied} is no user of this page; add one with: bt-orchestrator user add '
            f'{caller.proxied} --role ROLE'
        )


class _Answering:
    """Sends an answer, with the headers that each has."""

    def __init__(self, scope: Scope, send: Send) -> None:
        self.has_begun = False
        self._is_api = scope['path'].startswith('/api/')
        self._send = send

    async def send(self, message: Message) -> None:
        if message['type'] == 'http.response.start':
            self.has_begun = True
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
            if self._is_api:
                headers.setdefault('cache-control', 'no-store')
        await self._send(message)


def _check_origin(headers: Headers, host: str, scheme: str, access: Access) -> None:
    """Refuse what a page of another site sends with the cookie of this one."""
    origin = headers.get('origin', '')
    own = {f'{scheme}://{host}'}
    if access.proxy_header:  # the proxy speaks TLS, perhaps under another name
        names = (host, *access.allowed_hosts)
        own = {f'{protocol}://{name}' for protocol in ('http', 'https') for name in names}
    if origin.lower() not in {address.lower() for address in own}:
        expected = ' or '.join(sorted(own))
        raise Problem(
            403, f'a command comes from a page of {expected}; its Origin is {origin or "missing"}'
        )


def _check_content(headers: Headers) -> None:
    kind = headers.get('content-type', '').partition(';')[0].strip().lower()
    if kind != 'application/json':
        raise Problem(415, f'expected Content-Type application/json, found {kind or "none"}')


def _caller(scope: Scope, headers: Headers, access: Access) -> Caller:
    client = scope.get('client')
    return Caller(
        address=client[0] if client else '',
        key=Request(scope).cookies.get(access.cookie, ''),
        proxied=_proxied(headers, access),
    )


def _proxied(headers: Headers, access: Access) -> str:
    """Return the user whom the proxy names; a header that stands there twice names no user."""
    named = headers.getlist(access.proxy_header) if access.proxy_header else []
    return named[0].strip() if len(named) == 1 else ''


def _name_in(host: str) -> str:
    """Return the name in a Host header, without the port."""
    if host.startswith('['):
        return host.partition(']')[0].lstrip('[')
    return host.partition(':')[0]
