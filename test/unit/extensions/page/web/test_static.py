"""The files of the page: complete, of one piece, and nothing from elsewhere."""

import re
from pathlib import Path

from fakes.page_files import STATIC, modules

from bt_orchestrator.model.jobs.isa95 import OVER

ROOMS = ('core', 'asking', 'parts', 'screens')
"""From below; the files beside them are above."""

_IMPORT = re.compile(r'(?:\bfrom|\bimport)\s*\(?\s*[\'"](\.[^\'"]+)[\'"]')
_WORKER = re.compile(r'new SharedWorker\(\s*\'(/static/[^\']+)\'')
_SPACE_NAME = 'http://www.w3.org/2000/svg'
"""The name of a format; nothing is fetched from there."""


def test_nothing_is_fetched_from_elsewhere() -> None:
    for path in STATIC.rglob('*'):
        if path.is_file() and path.suffix != '.png':
            text = path.read_text(encoding='utf-8').replace(_SPACE_NAME, '')
            assert not re.search(r'https?://|@import|url\(', text), path


def test_all_modules_are_reachable_and_all_imports_exist() -> None:
    reached: set[Path] = set()
    waiting = [STATIC / 'app.js']
    while waiting:
        path = waiting.pop()
        if path not in reached:
            assert path.is_file(), path
            reached.add(path)
            waiting += _imports(path)
    assert sorted(reached) == modules()


def test_imports_of_modules_never_point_up() -> None:
    for path in modules():
        for imported in _imports(path):
            assert _level(imported) <= _level(path), f'{path.name} imports {imported.name}'


def test_every_style_is_used_by_the_page() -> None:
    index = (STATIC / 'index.html').read_text(encoding='utf-8')
    for path in (STATIC / 'style').iterdir():
        assert f'/static/style/{path.name}' in index


def test_a_class_is_styled_in_one_file() -> None:
    owners: dict[str, set[str]] = {}
    for path in (STATIC / 'style').glob('*.css'):
        for name in re.findall(r'^\.([\w-]+)', path.read_text(encoding='utf-8'), re.MULTILINE):
            owners.setdefault(name, set()).add(path.name)
    assert {name: files for name, files in owners.items() if len(files) > 1} == {}


def test_page_has_no_inline_style_or_script() -> None:
    index = (STATIC / 'index.html').read_text(encoding='utf-8')
    assert not re.search(r'<style|\sstyle=|\son\w+=|<script(?![^>]*\ssrc=)', index)
    for path in modules():
        text = path.read_text(encoding='utf-8')
        assert not re.search(r'innerHTML|outerHTML|insertAdjacentHTML|[{,]\s*style:', text), path


def test_modules_do_not_list_finished_job_states() -> None:
    for path in modules():
        text = path.read_text(encoding='utf-8')
        literals = [state.value for state in OVER if re.search(rf'[\'"]{state.value}[\'"]', text)]
        assert not literals, path


def test_modules_are_short() -> None:
    for path in modules():
        assert len(path.read_text(encoding='utf-8').splitlines()) <= 250, path


def _level(path: Path) -> int:
    room = path.relative_to(STATIC).parts[0]
    return ROOMS.index(room) if room in ROOMS else len(ROOMS)


def _imports(path: Path) -> list[Path]:
    text = path.read_text(encoding='utf-8')
    own = [(path.parent / name).resolve() for name in _IMPORT.findall(text)]
    workers = [STATIC / name.removeprefix('/static/') for name in _WORKER.findall(text)]
    return own + workers
