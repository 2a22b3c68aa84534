"""Pictures of scripts, as files; the real `dot` draws trees."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from fakes.shipped import REFERENCE_CELL, TREES
from patience import PATIENCE_S

SVG = '{http://www.w3.org/2000/svg}'
SCRIPT = TREES / 'inspect_and_assemble.yaml'


def render(*words: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, '-m', 'bt_orchestrator', 'render', str(SCRIPT), *map(str, words)]
    return subprocess.run(
        [*command, '--cell', str(REFERENCE_CELL)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        env={**os.environ, **environment},
        check=False,
    )


def test_an_svg_has_titles_for_readers_and_tooltips(tmp_path: Path) -> None:
    picture = tmp_path / 'picture.svg'
    done = render('-o', picture)
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')

    root = ET.parse(picture).getroot()
    texts = {''.join(text.itertext()).replace('\xa0', ' ') for text in root.iter(f'{SVG}text')}
    wanted = {'Section 1 · source', 'Section 5 · sink', 'TASK_A', '/component_2a/task'}
    assert wanted | {'flag camera_read', '■ zone shared_table', 'in parallel'} <= texts
    tooltips = [title.text or '' for title in root.iter(f'{SVG}title')]
    assert any(
        'argument special_argument_2: ${results.inspect.measurement}' in t for t in tooltips
    )
    assert any('components: component_1a' in t for t in tooltips)
    groups = {group.get('id') for group in root.iter(f'{SVG}g')}
    assert {'task.assemble', 'section.3', 'flag.camera_read', 'belt.4'} <= groups


def test_sections_are_where_the_text_puts_them(tmp_path: Path) -> None:
    picture = tmp_path / 'picture.svg'
    assert render('-o', picture).returncode == 0

    groups = {g.get('id'): g for g in ET.parse(picture).getroot().iter(f'{SVG}g')}
    lefts = [_left(groups[f'section.{number}']) for number in range(1, 6)]
    assert lefts == sorted(lefts)
    assert len(set(lefts)) == 5


def _left(group: ET.Element) -> float:
    return float(next(group.iter(f'{SVG}rect')).get('x', 'none'))


@pytest.mark.parametrize(
    ('ending', 'begins'), [('png', b'\x89PNG'), ('pdf', b'%PDF'), ('svg', b'<?xml')]
)
@pytest.mark.parametrize('view', ['line', 'tree'])
def test_formats(ending: str, begins: bytes, view: str, tmp_path: Path) -> None:
    picture = tmp_path / f'picture.{ending}'
    done = render('-o', picture, '--view', view)
    assert (done.returncode, done.stderr) == (0, '')
    assert picture.read_bytes().startswith(begins)


def test_without_dot(tmp_path: Path) -> None:
    done = render('-o', tmp_path / 'picture.png', '--view', 'tree', PATH='/nowhere')
    assert done.returncode == 1
    assert 'the program `dot` ' in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert render('-o', tmp_path / 'picture.png', PATH='/nowhere').returncode == 0


def test_an_unknown_ending_is_wrong_use(tmp_path: Path) -> None:
    done = render('-o', tmp_path / 'picture.gif')
    assert done.returncode == 2
    assert 'expected one of .svg, .png, .pdf, .dot' in done.stderr
