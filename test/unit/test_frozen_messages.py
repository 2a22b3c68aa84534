"""Messages that are part of a service do not change: a changed one breaks every built client."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest

MESSAGES = Path(__file__).parents[2] / 'interfaces' / 'bt_orchestrator_interfaces' / 'msg'
SERVICES = MESSAGES.parent / 'srv'

FROZEN = {
    'Event': '21f5b8000fabefdc',
    'JobStatus': '77fdb0ed1fac4625',
    'ListedJob': '5a6d221ad06ddac8',
    'OrderAnswer': 'f479088b3af25279',
    'WorkOrder': 'c8ff9ec0c7015783',
    'TaskStatus': '1f6dafad1281ed95',
    'PassedTask': '13100a9bef1629f2',
}
"""Digests of the text of the messages that requests and answers of services carry."""


@pytest.mark.parametrize('name', FROZEN)
def test_a_message_of_a_service_keeps_its_text(name: str) -> None:
    text = (MESSAGES / f'{name}.msg').read_bytes()
    assert hashlib.sha256(text).hexdigest()[:16] == FROZEN[name], (
        f'{name}.msg is part of a service. ROS 2 compares types by their whole definition, so a '
        'changed one makes every client that was built before unable to call the service. Put '
        'new fields into a message of Status that no service carries, as JobFacts.'
    )


def test_every_message_of_a_service_is_frozen() -> None:
    texts = [path.read_text() for path in SERVICES.glob('*.srv')]
    assert set(FROZEN) == _nested(texts)


def _nested(texts: list[str]) -> set[str]:
    """Return the messages of this package that definitions carry, at any depth."""
    messages: set[str] = set()
    for text in texts:
        own = re.findall(r'^([A-Z]\w+)(?:\[[^]]*])? ', text, re.MULTILINE)
        for name in set(own) - messages:
            messages |= {name} | _nested([(MESSAGES / f'{name}.msg').read_text()])
    return messages
