"""The description of the API (OpenAPI 3.1), made from the endpoints themselves."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Schema
from bt_orchestrator.extensions.page.web.replies import Json

PATH = '/api/openapi.json'

_PARAMETER = re.compile(r'{(\w+)(?::\w+)?}')

_ALWAYS: Mapping[int, str] = {
    403: 'the Host or the Origin is not that of this page',
    401: 'log in first',
}
_OF_POSTS: Mapping[int, str] = {
    413: 'the body is too long',
    415: 'the body is not application/json',
    422: 'the body does not fit; `message` says what was expected',
}


def with_description(endpoints: Sequence[Endpoint]) -> Sequence[Endpoint]:
    """Return endpoints and the one that describes them all."""
    described: list[Endpoint] = []

    async def answer(_: Request) -> Response:
        return Json(document(described))

    own = Endpoint('GET', PATH, answer, 'this description of the API')
    described += (*endpoints, own)
    return described


def document(endpoints: Sequence[Endpoint]) -> dict[str, Any]:
    """Return the description of some endpoints."""
    paths: dict[str, dict[str, Any]] = {}
    for endpoint in endpoints:
        path = _PARAMETER.sub(r'{\1}', endpoint.path)
        paths.setdefault(path, {})[endpoint.method.lower()] = _operation(endpoint)
    return {
        'openapi': '3.1.0',
        'info': {
            'title': 'The operator page of bt_orchestrator',
            'version': version('bt_orchestrator'),
            'description': 'A POST needs a session, an Origin header that is the address of the '
            'page, and a JSON object. Times are seconds since the epoch, durations seconds.',
        },
        'paths': paths,
        'components': {'schemas': {'Problem': _PROBLEM}},
    }


def _operation(endpoint: Endpoint) -> dict[str, Any]:
    refusals = {**_ALWAYS, **(_OF_POSTS if endpoint.method == 'POST' else {}), **endpoint.refusals}
    operation: dict[str, Any] = {
        'operationId': _id(endpoint),
        'summary': endpoint.does,
        'parameters': [
            *(_in_path(name) for name in _PARAMETER.findall(endpoint.path)),
            *(_in_query(name, meaning) for name, meaning in endpoint.query.items()),
        ],
        'responses': {
            '200': {'description': 'done', 'content': {endpoint.media: {}}},
            **{
                str(status): {'description': meaning, 'content': _PROBLEMS}
                for status, meaning in sorted(refusals.items())
            },
        },
    }
    if endpoint.method == 'POST':
        operation['requestBody'] = {'content': {'application/json': {'schema': _body(endpoint)}}}
    return operation


def _id(endpoint: Endpoint) -> str:
    words = re.findall(r'[a-z0-9]+', endpoint.path.removeprefix('/api'))
    return '_'.join([endpoint.method.lower(), *words])


def _in_path(name: str) -> dict[str, Any]:
    return {'name': name, 'in': 'path', 'required': True, 'schema': {'type': 'string'}}


def _in_query(name: str, meaning: str) -> dict[str, Any]:
    schema = {'type': 'string'}
    return {'name': name, 'in': 'query', 'description': meaning, 'schema': schema}


def _body(endpoint: Endpoint) -> Schema:
    return {
        'type': 'object',
        'properties': endpoint.body,
        'required': endpoint.required,
    }


_PROBLEM: Schema = {
    'type': 'object',
    'properties': {'message': {'type': 'string', 'description': 'what was expected, in words'}},
    'required': ['message'],
}
_PROBLEMS: Mapping[str, Any] = {
    'application/json': {'schema': {'$ref': '#/components/schemas/Problem'}}
}
