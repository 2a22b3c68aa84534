"""What the pages say is tried: files, commands, links, and the parts that are generated."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from fakes.action_types import FakeActionTypes
from fakes.schemas import refusals
from fakes.shipped import REFERENCE_CELL, ROOT, TREES
from fakes.yaml_parts import laid_over

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.cli.main import parsed, without_ros_arguments
from bt_orchestrator.cli.verbs import PROGRAM, VERBS, command_of, is_verb
from bt_orchestrator.extensions.recipes.reading.overrides_file import parse_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import parse_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.deadlock import deadlock
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell, read_cell
from bt_orchestrator.script.json_schema import SCHEMA_FILES
from bt_orchestrator.script.orders.order_file import bind_order, parse_order
from bt_orchestrator.script.script_file import parse_script, read_script
from bt_orchestrator.script.script_keys import SCRIPT
from bt_orchestrator.script.shifts.shifts_file import parse_reasons, parse_shifts

TYPES = FakeActionTypes()
_LINES = re.MULTILINE | re.DOTALL
SCRIPT_REFERENCE = 'docs/script_reference.md'
PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *(ROOT / 'docs').rglob('*.md'))
)


class Block(NamedTuple):
    """A fenced block of a page."""

    page: str
    line: int
    kind: str
    text: str

    @property
    def place(self) -> str:
        return f'{self.page}:{self.line}'

    def starts(self, key: str) -> bool:
        """Tell whether a YAML block has a top-level key."""
        return re.search(rf'^{key}:', self.text, re.MULTILINE) is not None


def text_of(page: str) -> str:
    return (ROOT / page).read_text(encoding='utf-8')


@cache
def blocks() -> tuple[Block, ...]:
    code_blocks = []
    for page in PAGES:
        text = text_of(page)
        for match in re.finditer(r'^```(\w*)\n(.*?)^```$', text, re.MULTILINE | re.DOTALL):
            line = text.count('\n', 0, match.start()) + 2
            code_blocks.append(Block(page, line, match[1], match[2]))
    return tuple(code_blocks)


def yaml_blocks() -> list[Block]:
    return [block for block in blocks() if block.kind == 'yaml']


# --- files ----------------------------------------------------------------------------------


class PageReader:
    """Reads the files that one page shows: scripts for the cell in front of them."""

    def __init__(self) -> None:
        self.cell: Cell = read_cell(REFERENCE_CELL, TYPES)
        self.scripts: dict[str, Script] = {}
        self.recipe: Recipe | None = None
        self.whole = ''
        """The first script that was shown; parts are shown of it."""

    def read(self, block: Block) -> str:
        """Read one block as what it is, and return the word for it."""
        if block.starts('cell'):
            self.cell = parse_cell(block.text, block.place, TYPES)
            return 'cell'
        if block.starts('recipe') and block.starts('quantity'):
            choice = parse_order(block.text, block.place).order.recipe
            assert choice is not None, block.place
            shown = {self.recipe.name} if self.recipe else set()
            assert {*choice.recipes} & {'WM-100', *shown}, block.place
            return 'work_order'
        if block.starts('recipe'):
            self.recipe = parse_recipe(block.text, block.place, self.cell, TYPES)
            return 'recipe'
        if block.starts('bind'):
            assert self.recipe is not None, block.place
            parse_overrides(block.text, block.place, self.recipe, self.cell)
            return 'overrides'
        if block.starts('shifts'):
            parse_shifts(block.text, block.place)
            return 'shifts'
        if block.starts('reasons'):
            parse_reasons(block.text, block.place)
            return 'reasons'
        if not block.starts('script'):
            self._read_script(laid_over(self.whole, block.text), block.place)
            return 'part'
        if block.starts('sections'):
            self.whole = self.whole or block.text
            self._read_script(block.text, block.place)
            return 'script'
        file = parse_order(block.text, block.place)
        name = file.order.script
        script = self.scripts.get(name) or read_script(TREES / f'{name}.yaml', self.cell, TYPES)
        bind_order(file.order, script, file.order.order or 'WO-1', file.places)
        return 'work_order'

    def _read_script(self, text: str, place: str) -> None:
        script = parse_script(text, place, self.cell, TYPES)
        assert refusals('script.schema.json', text) == [], place
        assert deadlock(script) is None, place
        self.scripts[script.name] = script


@pytest.mark.parametrize('page', sorted({block.page for block in yaml_blocks()}))
def test_yaml_on_a_page_passes_the_real_readers(page: str) -> None:
    reader = PageReader()
    kinds = []
    for block in yaml_blocks():
        if block.page == page:
            try:
                kinds.append(reader.read(block))
            except Refused as refused:
                pytest.fail(f'{block.place}:\n{refused}')
            if kinds[-1] not in ('part', 'script'):
                assert refusals(f'{kinds[-1]}.schema.json', block.text) == [], block.place
    assert kinds


def test_every_script_option_appears_in_an_example() -> None:
    chapters = re.split(r'^## ', text_of(SCRIPT_REFERENCE), flags=re.MULTILINE)
    for table in SCRIPT.tree():
        (chapter,) = (c for c in chapters if f'generated: keys of {table.name} -->' in c)
        elsewhere = 'own below' in chapter
        examples = ''.join(re.findall(r'^```yaml\n(.*?)^```$', chapter, re.DOTALL | re.MULTILINE))
        shown = set(re.findall(r'\b(\w+):', examples))
        missing = {key.name for key in table.keys if not (elsewhere and key.of)} - shown
        assert missing == set(), table.name


WITHOUT_RULES = {
    'a target',
    'a reason',
    'a file of reasons',
    'a component',
    'the conveyor',
    'a capability',
    'a preparation',
    'a recipe',
    'an operation',
    'a repeat of operations',
    'an overrides file',
    'a file of shifts',
    'a shift',
    'a break',
}
"""Mappings with keys that nothing of a line obeys: scripts are generated from them, or reports
made."""


def test_an_option_names_a_rule_that_exists() -> None:
    text = text_of('docs/semantics.md')
    for table in (table for root in SCHEMA_FILES.values() for table in root.tree()):
        for key in table.keys:
            if not key.rule and table.name in WITHOUT_RULES:
                continue
            chapter, _, rule = key.rule.partition('.')
            body = re.search(rf'^## {chapter}\. .*?(?=^## )', text, re.MULTILINE | re.DOTALL)
            assert chapter
            assert body, key.name
            assert f'\n{rule}. ' in body[0] or not rule, key.name


def test_every_kind_of_file_is_shown() -> None:
    for key in ('cell', 'sections', 'order', 'recipe', 'bind', 'shifts', 'reasons'):
        assert any(block.starts(key) for block in yaml_blocks()), key


def test_a_broken_block_would_be_seen() -> None:
    block = next(block for block in yaml_blocks() if block.starts('cell'))
    broken = block._replace(text=block.text.replace('conveyor:', 'convoy:'))
    with pytest.raises(Refused):
        PageReader().read(broken)


# --- commands -------------------------------------------------------------------------------


class Mention(NamedTuple):
    """The program named with a verb, as in code."""

    place: str
    verb: str
    words: str


def mentions() -> Iterator[Mention]:
    for page in PAGES:
        for number, line in enumerate(text_of(page).splitlines(), 1):
            for match in re.finditer(rf'(?:^|[`$ ]){PROGRAM} ([a-z][\w-]*)([^`#]*)', line):
                yield Mention(f'{page}:{number}', match[1], match[2])


@pytest.mark.parametrize('mention', list(mentions()), ids=lambda m: f'{m.place} {m.verb}')
def test_a_command_on_a_page_exists(mention: Mention) -> None:
    assert is_verb(mention.verb), mention.place
    words = without_ros_arguments(mention.words.split())
    parser = command_of([mention.verb, *words]).parser()
    known = {name for action in parser._actions for name in action.option_strings}
    used = {word.partition('=')[0] for word in words if word.startswith('--')}
    assert used <= known, mention.place


def shown_commands() -> Iterator[tuple[str, str]]:
    """Yield what a reader is to type, with its place; `…` after a command is none of it."""
    for page in PAGES:
        text = text_of(page)
        for block in re.finditer(r'^( *)```(?:sh|console)\n(.*?)^\1```$', text, _LINES):
            first = text.count('\n', 0, block.start(2)) + 1
            for number, line in enumerate(block[2].splitlines(), first):
                command = re.match(rf' *(?:\$ )?(?:ros2 run \w+ )?{PROGRAM} (.*)', line)
                if command is not None:
                    yield f'{page}:{number}', re.split(r'\s[#|>&]', command[1])[0]


@pytest.mark.parametrize(('place', 'command'), list(shown_commands()))
def test_shown_command_passes_the_real_parser(place: str, command: str) -> None:
    assert is_verb(parsed(shlex.split(command)).verb.split()[0]), place


def test_a_wrong_command_would_be_seen() -> None:
    with pytest.raises(SystemExit):
        parsed(['queue', 'mvoe', 'WO-7', '2'])
    pages = {place.partition(':')[0] for place, _ in shown_commands()}
    operator = ('guide', 'journal', 'operating', 'queue', 'simulate', 'troubleshooting')
    assert pages >= {'README.md', *(f'docs/{name}.md' for name in operator)}


def test_commands_are_mentioned() -> None:
    assert {mention.verb for mention in mentions()} == set(VERBS)


def test_scripts_on_a_page_exist() -> None:
    named = {
        name
        for page in PAGES
        for name in re.findall(r'(?<![\w/])\.?/?scripts/(\w+)', text_of(page))
    }
    assert {'bootstrap', 'demo', 'test'} <= named
    assert [name for name in sorted(named) if not (ROOT / 'scripts' / name).exists()] == []


# --- links ----------------------------------------------------------------------------------


class Link(NamedTuple):
    """A link from a page to a place in this repository."""

    page: str
    target: str
    anchor: str


def links() -> Iterator[Link]:
    for page in PAGES:
        text = re.sub(r'^```.*?^```$', '', text_of(page), flags=re.MULTILINE | re.DOTALL)
        for match in re.finditer(r'\[[^\]]*\]\(([^)#\s]*)(?:#([^)\s]*))?\)', text):
            if '://' not in match[1]:
                yield Link(page, match[1], match[2] or '')


def anchors(page: Path) -> set[str]:
    """Return what headings are called in links, as GitHub does it."""
    headings = re.findall(r'^#+ (.*)$', page.read_text(encoding='utf-8'), re.MULTILINE)
    return {re.sub(r'[^\w -]', '', heading.lower()).replace(' ', '-') for heading in headings}


@pytest.mark.parametrize(
    'link', list(links()), ids=lambda link: f'{link.page} {link.target}#{link.anchor}'
)
def test_a_link_leads_somewhere(link: Link) -> None:
    source = ROOT / link.page
    target = source.parent / link.target if link.target else source
    assert target.exists()
    if link.anchor:
        assert link.anchor in anchors(target)


def test_there_are_links() -> None:
    assert {link.page for link in links()} >= {'README.md', 'docs/architecture.md'}


# --- files ----------------------------------------------------------------------------------


def named_files(text: str) -> set[str]:
    """Return the files and folders that a page names as code, without their functions."""
    return set(re.findall(r'`([a-z_0-9/]+(?:/|\.py|\.js))(?:: [^`]*)?`', text))


def is_there(name: str) -> bool:
    """Tell whether a name is a path here, or the end of one in the package or in its tests."""
    name = name.rstrip('/')
    folders = (ROOT / 'bt_orchestrator', ROOT / 'test')
    return (ROOT / name).exists() or any(any(folder.rglob(name)) for folder in folders)


def test_files_that_the_architecture_names_exist() -> None:
    named = named_files(text_of('docs/architecture.md'))
    assert {'engine/runtime/orchestrator.py', 'model/events/', 'routes.js'} <= named
    assert [name for name in sorted(named) if not is_there(name)] == []


# --- size -----------------------------------------------------------------------------------


def test_the_architecture_fits_on_its_page() -> None:
    assert len(text_of('docs/architecture.md').splitlines()) <= 300


def test_each_decision_has_a_number_of_its_own() -> None:
    names = sorted(path.name for path in (ROOT / 'docs' / 'decisions').glob('[0-9]*.md'))
    numbers = [int(name[:4]) for name in names]
    assert sorted({*numbers}) == numbers
