"""Names that ROS 2 accepts for actions, topics, namespaces and types.

The rules are those of rcl and rmw (design.ros2.org, topic and service names), for names of other
nodes: a private name (`~/...`) or a substitution (`{node}`) names something of the node that uses
it, never a component's server, so both are refused here.
"""

from __future__ import annotations

import re

from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.yaml_nodes import quoted

LONGEST_TOPIC = 255 - 8
"""The part of a DDS name that rmw leaves."""

LONGEST_ACTION = LONGEST_TOPIC - len('/_action/cancel_goal')
"""An action's services and topics put their own endings behind its name."""

TOKEN_FORM = '[A-Za-z_][A-Za-z0-9_]*'
NAME_FORM = f'/?{TOKEN_FORM}(?:/{TOKEN_FORM})*'
ACTION_TYPE_FORM = '[a-z][a-z0-9_]*/action/[A-Z][A-Za-z0-9]*'
MESSAGE_TYPE_FORM = '[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*'
"""Patterns of complete names, for checks without a message."""

_TOKEN = re.compile(TOKEN_FORM)
_TYPES = {'action': re.compile(ACTION_TYPE_FORM), 'msg': re.compile(MESSAGE_TYPE_FORM)}


def check_action_name(name: str, place: Place, report: Report) -> bool:
    """Report an action name that ROS 2 refuses."""
    return _check(name, 'action', LONGEST_ACTION, place, report)


def check_topic_name(name: str, place: Place, report: Report) -> bool:
    """Report a topic name that ROS 2 refuses."""
    return _check(name, 'topic', LONGEST_TOPIC, place, report)


def check_token(name: str, kind: str, place: Place, report: Report) -> bool:
    """Report a name that cannot be one token of a ROS 2 name, such as a namespace."""
    if _TOKEN.fullmatch(name):
        return True
    what = f'{quoted(name)} cannot be a {kind} name: it must be one token of a ROS 2 name'
    report.add(place, what, f'write for instance `{legal_token(name, kind)}`')
    return False


def check_type_name(name: str, kind: str, place: Place, report: Report) -> bool:
    """Report a type name that is not package/action/Name or package/msg/Name."""
    if _TYPES[kind].fullmatch(name):
        return True
    parts = [part for part in re.split(r'[^A-Za-z0-9_]+', name) if part]
    last = ''.join(word[:1].upper() + word[1:] for word in parts[-1].split('_')) if parts else ''
    example = f'{parts[0].lower()}/{kind}/{last}' if len(parts) > 1 else ''
    if not _TYPES[kind].fullmatch(example):
        example = f'my_interfaces/{kind}/MyType'
    kinds = {'action': 'an action type', 'msg': 'a message type'}
    report.add(
        place,
        f'{quoted(name)} is not the name of {kinds[kind]}',
        f'write for instance `{example}`',
    )
    return False


def legal_name(name: str, kind: str) -> str:
    """Return a spelling of a name that ROS 2 accepts and that a reader recognizes."""
    tokens = [legal_token(token, kind) for token in name.split('/') if token.strip('~{}')]
    return ('' if re.match(r'[^/~]', name) else '/') + '/'.join(tokens or [f'my_{kind}'])


def legal_token(token: str, kind: str) -> str:
    """Return a spelling of one token: 1a_action becomes action_1a."""
    clean = re.sub(r'[^A-Za-z0-9_]+', '_', token).strip('_') or kind
    if not clean[0].isdigit():
        return clean
    number, _, rest = clean.partition('_')
    return f'{rest}_{number}' if rest and not rest[0].isdigit() else f'{kind}_{clean}'


def _check(name: str, kind: str, longest: int, place: Place, report: Report) -> bool:
    fault = _fault(name)
    if fault is not None:
        what = f'{quoted(name)} is not a legal {kind} name: {fault}'
        report.add(place, what, f'write for instance `{legal_name(name, kind)}`')
        return False
    if len(name) > longest:
        what = f'{quoted(name)} is not a legal {kind} name: it has {len(name)} characters'
        report.add(place, what, f'use at most {longest}')
        return False
    return True


def _fault(name: str) -> str | None:
    """Say which rule a name breaks."""
    if re.search(r'[~{}]', name):
        return 'private names and substitutions would mean this node, not the component'
    if '//' in name:
        return 'it has two slashes in a row'
    if name.endswith('/'):
        return 'it ends with a slash'
    for token in name.removeprefix('/').split('/'):
        if token and token[0].isdigit() and token[0].isascii():
            return f'the token {quoted(token)} starts with a digit'
        if not _TOKEN.fullmatch(token):
            return f'{quoted(token)} has characters other than letters, digits and `_`'
    return None
