"""A browser without a network: it calls an ASGI application, and keeps its cookies."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import unquote, urlsplit


@dataclass(frozen=True)
class Answered:
    """An answer as a browser sees it."""

    status: int
    headers: Mapping[str, str]
    body: bytes
    set_cookies: tuple[str, ...] = ()

    @property
    def json(self) -> Any:
        """The body."""
        return json.loads(self.body)

    @property
    def message(self) -> str:
        """What an error says."""
        text: str = self.json['message']
        return text


@dataclass
class Browser:
    """One browser at one computer."""

    app: Callable[..., Any]
    loop: asyncio.AbstractEventLoop
    """Where the application lives."""
    host: str = '127.0.0.1:8080'
    address: str = '127.0.0.1'
    scheme: str = 'http'
    cookies: dict[str, str] = field(default_factory=dict)
    headers: dict[str, str] = field(default_factory=dict)
    """In every request; an empty one is left out."""
    sends_whole: bool = True
    """Or sends the beginning of a body, and no more."""

    def get(self, path: str, **headers: str) -> Answered:
        """Ask for something."""
        return self.loop.run_until_complete(self.asked('GET', path, b'', headers))

    def post(self, path: str, body: object = None, **headers: str) -> Answered:
        """Send something."""
        return self.loop.run_until_complete(self.posted(path, body, **headers))

    async def posted(self, path: str, body: object = None, **headers: str) -> Answered:
        """Send something, while other things happen."""
        text = body if isinstance(body, bytes) else json.dumps(body or {}).encode()
        return await self.asked('POST', path, text, headers)

    async def asked(
        self, method: str, path: str, body: bytes, more: Mapping[str, str]
    ) -> Answered:
        """Make any request.

        :param more: headers, with `_` for `-`; an empty one is left out
        """
        place = urlsplit(path)
        scope = {
            'type': 'http',
            'asgi': {'version': '3.0'},
            'http_version': '1.1',
            'method': method,
            'scheme': self.scheme,
            'path': unquote(place.path),
            'raw_path': place.path.encode(),
            'query_string': place.query.encode(),
            'root_path': '',
            'headers': self._headers(method, more),
            'client': (self.address, 4711),
            'server': ('127.0.0.1', 8080),
            'state': {},
        }
        more_comes = not self.sends_whole
        pieces = [{'type': 'http.request', 'body': body, 'more_body': more_comes}]
        sent: list[dict[str, Any]] = []

        async def receive() -> dict[str, Any]:
            if not pieces:
                await asyncio.Future()  # a browser stays until it has its answer
            return pieces.pop(0)

        async def send(message: dict[str, Any]) -> None:
            sent.append(message)

        await self.app(scope, receive, send)
        return self._answered(sent)

    def _headers(self, method: str, more: Mapping[str, str]) -> list[tuple[bytes, bytes]]:
        own = {'host': self.host, **self.headers}
        if method == 'POST':
            own |= {'origin': f'{self.scheme}://{self.host}', 'content-type': 'application/json'}
        if self.cookies:
            own['cookie'] = '; '.join(f'{name}={value}' for name, value in self.cookies.items())
        own |= {name.lower().replace('_', '-'): value for name, value in more.items()}
        return [(name.encode(), value.encode()) for name, value in own.items() if value]

    def _answered(self, sent: list[dict[str, Any]]) -> Answered:
        start = sent[0]
        headers = [(name.decode(), value.decode()) for name, value in start['headers']]
        set_cookies = tuple(value for name, value in headers if name == 'set-cookie')
        for cookie in set_cookies:
            for name, morsel in SimpleCookie(cookie).items():
                self.cookies.pop(name, None)
                if morsel.value and morsel['max-age'] != '0':
                    self.cookies[name] = morsel.value
        body = b''.join(message.get('body', b'') for message in sent[1:])
        return Answered(start['status'], dict(headers), body, set_cookies)
