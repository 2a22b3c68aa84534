"""An endpoint of the API: what its route, its row in the docs and in OpenAPI are made of."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from starlette.responses import Response
from starlette.routing import Route

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
