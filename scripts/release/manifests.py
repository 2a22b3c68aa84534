"""package.xml and changelog as bloom reads them, and their keys as rosdep resolves them."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from outcome import Outcome, Place, end_of, run

SYSTEMS = {'jazzy': 'ubuntu:noble', 'kilted': 'ubuntu:noble', 'lyrical': 'ubuntu:resolute'}
"""Distributions of ROS 2, and the system that each is released for."""

VALIDATE = """
import sys
from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
versions, warnings = set(), []
for folder in sys.argv[1:]:
    package = parse_package(folder)
    package.validate(warnings=warnings)
    versions.add(package.version)
    get_changelog_from_path(folder)
sys.exit('; '.join(warnings) or (len(versions) != 1 and f'versions differ: {versions}') or 0)
"""


def look(place: Place) -> Iterator[Outcome]:
    folders = (place.root, place.root / 'interfaces' / 'bt_orchestrator_interfaces')
    done = run(place.tools / 'python', '-c', VALIDATE, *folders)
    failed = done.returncode != 0
    yield Outcome('package.xml', end_of(done) if failed else 'as bloom wants it', failed)
    with tempfile.TemporaryDirectory() as home:
        yield from _resolve(place, Path(home))


def _resolve(place: Place, home: Path) -> Iterator[Outcome]:
    """Ask the public index, or the copy that ROSDEP_SOURCE_PATH and ROSDISTRO_INDEX_URL name."""
    own = {name: os.environ[name] for name in ('ROSDISTRO_INDEX_URL',) if name in os.environ}
    sources = os.environ.get('ROSDEP_SOURCE_PATH', str(home / 'sources'))
    variables = {**own, 'ROS_HOME': str(home), 'ROSDEP_SOURCE_PATH': sources}
    rosdep = place.tools / 'rosdep'
    if not Path(sources).exists():
        done = run(rosdep, 'init', variables=variables)
        if done.returncode:
            found = f'no index can be had here ({_why(done.stderr)})'
            yield Outcome('rosdep keys', found, done=False)
            return
    for distro, system in SYSTEMS.items():
        update = run(rosdep, 'update', '--rosdistro', distro, variables=variables)
        if update.returncode:
            yield Outcome(f'rosdep keys, {distro}', _why(update.stderr), done=False)
            continue
        paths = ('--from-paths', place.root, place.root / 'interfaces', '--ignore-src')
        wanted = ('--simulate', '--rosdistro', distro, f'--os={system}')
        done = run(rosdep, 'install', *wanted, *paths, variables=variables)
        failed = done.returncode != 0
        found = end_of(done) if failed else f'all known for {system}'
        yield Outcome(f'rosdep keys, {distro}', found, failed)


def _why(stderr: str) -> str:
    return (stderr.strip().splitlines() or ['it said nothing'])[-1].strip()
