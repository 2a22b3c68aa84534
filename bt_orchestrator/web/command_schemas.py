"""What the routes of commands take, as JSON Schemas: from the table of requests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from bt_orchestrator.model.limits import NAME, ORDERS, REASON
from bt_orchestrator.model.requests import TABLE, About, Kind, Parameter, Request, Why
from bt_orchestrator.script.json_schema import json_schema
from bt_orchestrator.script.script_keys import ORDER
from bt_orchestrator.web import command_paths as paths
from bt_orchestrator.web.endpoint import Schema

DOES: Mapping[str, str] = {
    paths.ANY: 'makes any request by its name, as in job.move; the body has its arguments',
    paths.ANSWER: 'answers a hold',
    paths.CELL_COMMAND: 'gives the cell a command, which stands in the path',
    paths.ITEM: 'records that an item was taken off the belt',
    paths.COMPONENT: 'takes a component out of service, or brings it back',
    paths.SCRIPT: 'releases a generated script, so that its jobs may start',
    paths.QUEUE_ADD: 'queues work orders, all or none; each needs an id of its own',
    paths.QUEUE_MOVE: 'gives a queued job another place, or the first one',
    paths.QUEUE_UPDATE: 'changes a queued job; what is left out stays',
    paths.QUEUE_COMMAND: 'gives a job a command',
    paths.QUEUE_STOP_AFTER: 'lets the cell stop after the current item or job, or not',
}


class Body(TypedDict):
    """Members of a body."""

    body: Mapping[str, Schema]
    required: tuple[str, ...]


def body_at(path: str) -> Body:
    """Return what is posted to a path."""
    if path == paths.ANY:
        of_all = {one.name: _schema(one) for request in TABLE for one in request.parameters}
        return Body(body={**of_all, **_ALWAYS}, required=())
    requests = requests_at(path)
    says = [{**paths.place_of(one, 'x').body} for one in requests]
    words = {key for said in says for key in said if key != 'job'}
    body: dict[str, Schema] = {
        key: _choice([said[key] for said in says if key in said]) for key in sorted(words)
    }
    for request in requests:
        for parameter in request.parameters:
            if parameter is not request.subject or request.about is About.JOB:
                body.setdefault(parameter.name, _schema(parameter))
    body |= _ALWAYS
    always = {key for key in words if all(key in said for said in says)}
    return Body(body=body, required=(*sorted(always), *_required(requests)))


def requests_at(path: str) -> Sequence[Request]:
    """Return the requests that are posted to a path."""
    return [one for one in TABLE if paths.pattern_of(one) == path]


def _required(requests: Sequence[Request]) -> list[str]:
    """Return the parameters without which no request goes."""
    needed = [
        {one.name for one in request.parameters if one.is_required and _is_in_body(one, request)}
        | ({'reason'} if request.why is Why.FIRST else set())
        for request in requests
    ]
    return sorted(set.intersection(*needed))


def _is_in_body(parameter: Parameter, request: Request) -> bool:
    return parameter is not request.subject or request.about is About.JOB


def _choice(values: Sequence[object]) -> Schema:
    return {'type': 'boolean'} if values[0] is True else {'type': 'string', 'enum': values}


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
