"""The words that the comments of services list are those of the table of requests."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from bt_orchestrator.model.packml import VERBS
from bt_orchestrator.model.requests import TABLE, About

SRV = Path(__file__).parents[3] / 'interfaces' / 'bt_orchestrator_interfaces' / 'srv'


def listed(service: str, field: str) -> set[str]:
    """Return the words behind a field of a request."""
    text = (SRV / f'{service}.srv').read_text(encoding='utf-8')
    (comment,) = re.findall(rf'^string {field} +# (.*)$', text, re.MULTILINE)
    return set(re.split(r', | or ', comment))


def words(about: About) -> set[str]:
    """Return the words that a service with typed fields may carry."""
    rows = [each for each in TABLE if each.about is about and not each.is_manual]
    return {request.word for request in rows} | {w for request in rows for w in request.also}


@pytest.mark.parametrize(
    ('service', 'expected'),
    [
        ('Command', set(VERBS.values()) | words(About.COMPONENT) | words(About.SCRIPT)),
        (
            'QueueCommand',
            words(About.JOB) - {'move', 'update'},
        ),  # these have services of their own
    ],
)
def test_a_service_lists_its_words(service: str, expected: set[str]) -> None:
    assert listed(service, 'command') == expected
