"""The licences of what runs with bt_orchestrator, and the bill of materials of an environment."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from xml.etree import ElementTree

from outcome import Outcome, Place, end_of, run

TOOLS = ('browser', 'dev', 'docs', 'installers', 'mixes', 'node', 'release')
"""Lists of what tests and releases need; a user installs nothing of them."""

PAGE = Path('docs', 'licences.md')
PART = re.compile(r'(?<=<!-- generated: licences -->\n\n).*?(?=\n<!-- end -->)', re.DOTALL)
UNKNOWN = 'UNKNOWN'


def look(place: Place) -> Iterator[Outcome]:
    environment = place.root / '.venv' / 'jazzy'
    python = environment / 'bin' / 'python'
    done = run(
        place.tools / 'pip-licenses', f'--python={python}', '--format=json', '--with-system'
    )
    if done.returncode:
        yield Outcome('licences', end_of(done), failed=True)
        return
    said = {_name(entry['Name']): entry['License'] for entry in json.loads(done.stdout)}
    licences = {name: _of(name, said, environment) for name in pinned(place.lists)}
    if unknown := [name for name, licence in licences.items() if licence == UNKNOWN]:
        yield Outcome('licences', f'not known: {", ".join(unknown)}', failed=True)
    text = (place.root / PAGE).read_text(encoding='utf-8')
    new = PART.sub(lambda _: '\n'.join(table(licences)), text)
    if place.write:
        (place.root / PAGE).write_text(new, encoding='utf-8')
    elif new != text:
        remedy = 'scripts/release-check licences --write'
        yield Outcome('licences', f'{PAGE} is not up to date: {remedy}', failed=True)
        return
    yield Outcome('licences', f'{len(licences)} packages in {PAGE}')


def pinned(lists: Path) -> list[str]:
    """Return the packages of PyPI that a user may get, of the distribution that is tested most."""
    paths = [path for path in lists.glob('*.txt') if path.stem not in (*TOOLS, 'kilted')]
    texts = (path.read_text(encoding='utf-8') for path in paths)
    return sorted({name for text in texts for name in re.findall(r'(?m)^([\w.-]+)==', text)})


def table(licences: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of the table: each licence with its packages."""
    by_licence: dict[str, list[str]] = {}
    for name, licence in licences.items():
        by_licence.setdefault(licence, []).append(f'`{name}`')
    yield from ('| licence | packages |', '|---|---|')
    for licence in sorted(by_licence, key=str.lower):
        yield f'| {licence} | {", ".join(by_licence[licence])} |'


def write_sbom(place: Place) -> Iterator[Outcome]:
    for environment in sorted((place.root / '.venv').glob('*/bootstrap')):
        python = environment.parent / 'bin' / 'python'
        name = f'sbom-{environment.parent.name}.cdx.json'
        done = run(
            *(place.tools / 'cyclonedx-py', 'environment', python, '--output-reproducible'),
            *('--validate', '--output-file', place.results / name),
        )
        failed = done.returncode != 0
        if failed:
            yield Outcome(name, end_of(done), failed)
            continue
        parts = json.loads((place.results / name).read_text(encoding='utf-8'))['components']
        yield Outcome(name, f'{len(parts)} components, valid, in {place.results}')


def _of(name: str, said: Mapping[str, str], environment: Path) -> str:
    """Return what the metadata says; wheels of ROS 2 say it in the package.xml that they bring."""
    licence = said.get(name, UNKNOWN)
    if licence not in (UNKNOWN, '%LICENSE'):
        return licence
    share = environment / 'share'
    bare = re.sub('^ros-(jazzy-)?', '', name).replace('-', '_')
    manifests: Sequence[Path] = [*share.glob(f'{bare}/package.xml')]
    texts = [node.text for path in manifests for node in ElementTree.parse(path).iter('license')]
    return ', '.join(text for text in texts if text) or _BY_HAND.get(name, UNKNOWN)


_BY_HAND: Mapping[str, str] = {
    'empy': 'LGPL',
    'exceptiongroup': 'MIT',
    'ros-fastcdr': 'Apache License 2.0',
    'ros-fastrtps': 'Apache License 2.0',
    'six': 'MIT',
}
"""Read in the source: the wheel does not say it, or older Pythons alone need the package."""


def _name(name: str) -> str:
    return re.sub('[-_.]+', '-', name).lower()
