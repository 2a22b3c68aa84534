"""scripts/release: what pip-audit and npm audit say, a network that is away, and licences."""

from __future__ import annotations

import json
import re

import audit
import licences
import pytest
from fakes.shipped import ROOT

LISTS = ROOT / 'scripts' / 'requirements'
CLEAN = {'name': 'rich', 'version': '15.0.0', 'vulns': []}
HOLE = {
    'name': 'pillow',
    'version': '9.0.0',
    'vulns': [{'id': 'PYSEC-2023-175', 'fix_versions': ['10.0.1'], 'aliases': ['CVE-2023-4863']}],
}
SKIPPED = {'name': 'ros-rcl', 'skip_reason': 'Dependency not found on PyPI'}


def said(*packages: object) -> str:
    return json.dumps({'dependencies': packages, 'fixes': []})


@pytest.mark.parametrize(
    ('packages', 'accepted', 'line'),
    [
        ([CLEAN, CLEAN], {}, 'ok       Python packages: 2 of 2 looked up, no known hole'),
        ([CLEAN, SKIPPED], {}, 'ok       Python packages: 1 of 2 looked up, no known hole'),
        ([SKIPPED], {}, 'NOT DONE Python packages: no advisories can be had here (of 1)'),
        (
            [HOLE],
            {'PYSEC-2023-175': 'no picture of others is opened'},
            (
                'ok       Python packages: 1 of 1 looked up, '
                'known holes, all explained: PYSEC-2023-175'
            ),
        ),
    ],
)
def test_pip_audit_is_judged(packages: list[object], accepted: dict[str, str], line: str) -> None:
    outcome = audit.of_python(said(*packages), '', accepted)
    assert (str(outcome), outcome.failed) == (line, False)


def test_known_vulnerability_fails_and_names_its_package() -> None:
    outcome = audit.of_python(said(CLEAN, HOLE), '', {'PYSEC-2000-1': 'another one'})
    assert outcome.failed
    assert 'PYSEC-2023-175 in pillow 9.0.0; pin another release' in str(outcome)


@pytest.mark.parametrize(
    'error',
    [
        'requests.exceptions.ProxyError: Failed to establish a new connection: refused\n',
        'ERROR:pip_audit._cli: Tip: your network may be blocking this service.\n',
    ],
)
def test_unreachable_network_is_named_but_fails_nothing(error: str) -> None:
    line = 'NOT DONE Python packages: no advisories can be had here (no connection)'
    assert str(audit.of_python('', error, {})) == line


def test_failed_scan_is_not_an_unreachable_network() -> None:
    error = 'WARNING: a\nERROR:pip_audit._cli:package six has duplicate requirements\n'
    line = 'FAILED   Python packages: ERROR:pip_audit._cli:package six has duplicate requirements'
    assert str(audit.of_python('', error, {})) == line


def test_rounds_cover_every_release_without_repeating_packages() -> None:
    rounds = audit.rounds(LISTS.glob('*.txt'))
    pins = {pin for pins in rounds for pin in pins}
    assert any(pin.startswith('ros-rclpy==9') for pin in pins)
    assert any(pin.startswith('ros-rclpy==7') for pin in pins)
    assert len(pins) == sum(map(len, rounds)) > 200
    for names in ([pin.partition('==')[0] for pin in pins] for pins in rounds):
        assert len(set(names)) == len(names)


NPM_HOLE = {
    'vulnerabilities': {
        'lodash': {
            'severity': 'high',
            'via': [{'url': 'https://github.com/advisories/GHSA-1', 'severity': 'high'}, 'other'],
        }
    },
    'metadata': {'dependencies': {'total': 120}},
}
NPM_CLEAN = {'vulnerabilities': {}, 'metadata': {'dependencies': {'total': 120}}}
NPM_AWAY = {'message': '405 Method Not Allowed - POST somewhere', 'error': {'summary': ''}}


NPM_ALONE = {'message': 'request to there failed, reason: connect ECONNREFUSED', 'error': {}}
NPM_BROKEN = {'message': 'loadVirtual requires existing shrinkwrap file', 'error': {}}


@pytest.mark.parametrize(
    ('answer', 'accepted', 'line', 'failed'),
    [
        (NPM_CLEAN, {}, 'ok       npm packages: 120 of 120 looked up, no known hole', False),
        (NPM_AWAY, {}, 'NOT DONE npm packages: no advisories can be had here (405 ', False),
        (NPM_ALONE, {}, 'NOT DONE npm packages: no advisories can be had here (conn', False),
        (NPM_BROKEN, {}, 'FAILED   npm packages: loadVirtual requires', True),
        (NPM_HOLE, {}, 'FAILED   npm packages: 120 of 120 looked up; GHSA-1 in lodash', True),
        (NPM_HOLE, {'GHSA-1': 'tests only'}, 'all explained: GHSA-1', False),
    ],
)
def test_npm_audit_is_judged(
    answer: object, accepted: dict[str, str], line: str, failed: bool
) -> None:
    outcome = audit.of_npm(json.dumps(answer), accepted)
    assert line in str(outcome)
    assert outcome.failed == failed


def test_npm_that_ends_without_an_answer_has_failed() -> None:
    assert str(audit.of_npm('', {})) == 'FAILED   npm packages: it said nothing'


def test_every_accepted_hole_has_a_reason() -> None:
    accepted = audit.read_accepted(audit.ACCEPTED.read_text(encoding='utf-8'))
    assert [name for name, reason in accepted.items() if len(reason.split()) < 3] == []


def test_every_shipped_package_has_its_licence_listed() -> None:
    text = (ROOT / licences.PAGE).read_text(encoding='utf-8')
    rows = re.findall(r'^\| (?!licence|---)(.+?) \| (.+) \|$', text, re.MULTILINE)
    listed = [name for _, names in rows for name in re.findall(r'`([^`]+)`', names)]
    assert sorted(listed) == licences.pinned(LISTS)
    assert licences.UNKNOWN not in {licence for licence, _ in rows}


def test_lists_of_tools_are_named_right() -> None:
    assert {f'{name}.txt' for name in licences.TOOLS} <= {path.name for path in LISTS.iterdir()}
