"""The paths of requests, and what is posted there, from the table of requests."""

from __future__ import annotations

import re
from collections.abc import Mapping, MutableMapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, NamedTuple, TypedDict

from bt_orchestrator.extensions.page.web.endpoint import Schema
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.limits import NAME, ORDERS, REASON
from bt_orchestrator.model.requests import (
    REQUESTS,
    TABLE,
    BadArguments,
    Kind,
    Parameter,
    Request,
    Why,
    of_name,
)
from bt_orchestrator.script.json_schema import json_schema
from bt_orchestrator.script.script_keys import ORDER

ANY = '/api/requests/{name}'
"""Takes every request; offers name no other path."""


class Place(NamedTuple):
    """The content of a post to a path."""

    does: str
    """One sentence without a full stop."""
    name: str
    """Of its request; `*` stands for what `key` says."""
    key: str = ''
    """Part of the path, or member of the body."""
    says: Mapping[str, str] = {}
    """Words by the JSON of that member; empty: it is the word."""


PLACES: Mapping[str, Place] = {
    ANY: Place(
        'makes any request by its name, as in job.move; the body has its arguments', '*', 'name'
    ),
    '/api/holds/{hold}/answer': Place('answers a hold', 'hold.*', 'answer'),
    '/api/cell/{command}': Place(
        'gives the cell a command, which stands in the path', 'cell.*', 'command'
    ),
    '/api/items/{item:path}/remove': Place(
        'records that an item was taken off the belt', 'item.remove_item'
    ),
    '/api/components/{component:path}/service': Place(
        'takes a component out of service, or brings it back', 'component.*', 'command'
    ),
    '/api/scripts/{script:path}/release': Place(
        'releases a generated script: its jobs may start', 'script.release_script'
    ),
    '/api/queue/add': Place(
        'queues work orders, all or none; each needs an id of its own', 'queue.add'
    ),
    '/api/queue/command': Place('gives a job a command', 'job.*', 'command'),
    '/api/queue/move': Place(
        'gives a queued job another place, or the first one',
        'job.*',
        'next',
        {'true': 'next', 'false': 'move', 'null': 'move'},
    ),
    '/api/queue/update': Place('changes a queued job; what is left out stays', 'job.update'),
    '/api/queue/stop_after': Place(
        'lets the cell stop after the current item or job, or not', 'cell.stop_after_*', 'after'
    ),
}
"""By path: any request, then the paths of earlier versions, from general to special ones."""


class Body(TypedDict):
    """Members of a body."""

    body: Mapping[str, Schema]
    required: tuple[str, ...]


def request_at(path: str, given: MutableMapping[str, Any]) -> Request:
    """Return the request that was posted to a path.

    :param given: body and parts of the path; only its arguments are left in it
    :raises BadArguments: it is none; says what was expected
    """
    place = PLACES[path]
    if not place.key:
        return REQUESTS[place.name]
    value = given.pop(place.key, None)
    word = place.says.get(json_of(value)) if place.says else value
    request = of_name(place.name.replace('*', word)) if isinstance(word, str) else None
    if request is None:
        expected = ', '.join(place.says or _words_at(path))
        raise BadArguments(f'{place.key} is one of {expected}; found {value!r:.60}')
    return request


def body_at(path: str) -> Body:
    """Return what is posted to a path."""
    place, in_path, requests = PLACES[path], _IN_PATH.findall(path), _requests_at(path)
    words = {'type': 'boolean'} if place.says else {'type': 'string', 'enum': _words_at(path)}
    parameters = {
        parameter.name: _schema(parameter)
        for request in requests
        for parameter in request.parameters
    }
    body = {name: value for name, value in {place.key: words, **parameters}.items() if name}
    needed = set.intersection(*map(_needed, requests)) | ({place.key} if not place.says else set())
    return Body(
        body={**{name: body[name] for name in body if name not in in_path}, **_ALWAYS},
        required=tuple(sorted(needed.difference(in_path, ['']))),
    )


_IN_PATH = re.compile(r'{(\w+)')


def _requests_at(path: str) -> Sequence[Request]:
    """Return the requests that have no path more special than this one."""
    return [request for request in TABLE if path in (ANY, _path_of(request))]


def _path_of(request: Request) -> str:
    return next(path for path in reversed(list(PLACES)) if _takes(PLACES[path], request))


def _takes(place: Place, request: Request) -> bool:
    is_said = not place.says or request.word in place.says.values()
    return is_said and fnmatchcase(request.name, place.name)


def _words_at(path: str) -> Sequence[str]:
    """Return what may stand for `*` in the name of a request."""
    before = len(PLACES[path].name.rstrip('*'))
    return [request.name[before:] for request in _requests_at(path)]


def _needed(request: Request) -> set[str]:
    """Return the members without which a request does not go."""
    needed = {parameter.name for parameter in request.parameters if parameter.is_required}
    return needed | ({'reason'} if request.why is Why.FIRST else set())


def _schema(parameter: Parameter) -> Schema:
    schema: dict[str, Any] = {**_KINDS[parameter.kind], 'description': parameter.meaning}
    if parameter.kind is Kind.WHOLE:
        schema['minimum'], schema['maximum'] = parameter.span
    if parameter.roles is not None:
        roles = ', '.join(sorted(role.value for role in parameter.roles))
        schema['description'] += f' (for {roles})'
    if parameter.choices:
        schema['enum'] = parameter.choices
    return schema


_ORDER: Schema = {key: value for key, value in json_schema(ORDER).items() if key != '$schema'}

_KINDS: Mapping[Kind, Schema] = {
    Kind.TEXT: {'type': 'string', 'maxLength': NAME},
    Kind.WHOLE: {'type': 'integer'},
    Kind.YES_NO: {'type': 'boolean'},
    Kind.TEXTS: {'type': 'array', 'items': {'type': 'string'}},
    Kind.VALUES: {'type': 'object'},
    Kind.ORDERS: {'type': 'array', 'items': _ORDER, 'minItems': 1, 'maxItems': ORDERS},
}

_ALWAYS: Mapping[str, Schema] = {
    'reason': {'type': 'string', 'maxLength': REASON, 'description': 'why, for the record'},
    'ticket': {
        'type': 'string',
        'pattern': '^[0-9a-f]{16}$',
        'description': 'random number of this command: the same one again is not done twice; '
        'one is made if it is left out',
    },
}
