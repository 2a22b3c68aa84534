"""Damaged files are refused with findings, never with anything else."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.profiles import PROFILE
from fakes.script_texts import mistakes

from bt_orchestrator.errors import Refused
from bt_orchestrator.script.cell_file import parse_cell, read_cell
from bt_orchestrator.script.cell_keys import CELL
from bt_orchestrator.script.order_file import bind_order, parse_order
from bt_orchestrator.script.script_file import parse_script, read_script
from bt_orchestrator.script.script_keys import ORDER, SCRIPT

ROOT = Path(__file__).parents[3]
SCRIPTS = (
    'trees/reference_process.yaml',
    'trees/inspect_and_assemble.yaml',
    'test/data/stuck.yaml',
)
FILES = ('config/reference_cell.yaml', *SCRIPTS, 'config/orders/wo_1001.yaml')

KEYS = {key.name for root in (CELL, SCRIPT, ORDER) for table in root.tree() for key in table.keys}

LINE_END = re.compile('\r\n|[\n\r\x85\u2028\u2029]')

TRIES = 20_000 if PROFILE == 'nightly' else 100
"""Damaged copies of each file."""

TYPES = FakeActionTypes()
REFERENCE_CELL = read_cell(ROOT / FILES[0], TYPES)
PROCESS = read_script(ROOT / SCRIPTS[0], REFERENCE_CELL, TYPES)

SPLINTERS = (
    *('${', '}', '${params.label}', '${results.inspect.x}', '{', '[', ']', ':', '- ', '&a ', '*a'),
    *('<<: *a', '!!python/object:x ', '!!str ', '\t', '\n', '"', "'", '|', '#', '---\n', '? '),
    *('0', '-1', '1e999', '.inf', '.nan', 'null', 'true', '~', '99999999999999999999', '\x00'),
    *(
        '\ud800',
        '\u2028',
        '\ufeff',
        'ä',
        'parallel',
        'task',
        'index',
        'init.1',
        '1',
        'runs_for: all',
    ),
)


def mutated(text: str, chance: random.Random) -> str:
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(text) + 1)
        end = min(len(text), at + chance.randint(0, 12))
        lines = text.split('\n')
        number = chance.randrange(len(lines))
        words = re.findall(r'[\w./]+', text) or ['a']
        text = chance.choice(
            (
                text[:at] + text[end:],
                text[:at] + chance.choice(SPLINTERS) + text[at:],
                text[:at] + chance.choice(words) + text[end:],
                '\n'.join([*lines[:number], *lines[number + 1 :]]),
                '\n'.join([*lines[:number], lines[number], *lines[number:]]),
                text.replace(chance.choice(words), chance.choice(words), 1),
            )
        )
    return text


def read(name: str, text: str) -> None:
    """Read a text as the kind of file that its name says."""
    if name.endswith('cell.yaml'):
        parse_cell(text, name, TYPES)
    elif 'orders' in name:
        order = parse_order(text, name)
        bind_order(order.order, PROCESS, 'J1', order.places)
    else:
        parse_script(text, name, REFERENCE_CELL, TYPES)


def check_wording(refusal: Refused, damaged: str) -> None:
    assert refusal.findings
    for finding in refusal.findings:
        assert 1 <= finding.line <= len(LINE_END.split(damaged)) + 1, damaged
        assert finding.column >= 1, damaged
        assert finding.what, damaged
        assert finding.hint, damaged
        str(finding).encode()
        assert '\n' not in str(finding), damaged


@pytest.mark.parametrize('name', FILES)
def test_a_damaged_file_is_refused_in_words(name: str) -> None:
    text = (ROOT / name).read_text(encoding='utf-8')
    seed = name if PROFILE == 'gate' else random.randrange(2**32)
    chance = random.Random(seed)
    refused = 0
    for _ in range(TRIES):
        damaged = mutated(text, chance)
        try:
            read(name, damaged)
        except Refused as refusal:
            refused += 1
            check_wording(refusal, damaged)
    assert refused > TRIES // 2, seed


@pytest.mark.parametrize('name', FILES)
def test_a_misspelt_key_is_one_mistake(name: str) -> None:
    text = (ROOT / name).read_text(encoding='utf-8')
    keys = [one for one in re.finditer(r'\b[a-z_]{4,}(?=:)', text) if one.group() in KEYS]
    assert keys
    for key in keys:
        word = key.group()
        damaged = text[: key.start()] + word[0] + word[2] + word[1] + word[3:] + text[key.end() :]
        found = mistakes(lambda: read(name, damaged))  # noqa: B023 - called at once
        assert [f'did you mean `{word}`?' in one for one in found] == [True], damaged
