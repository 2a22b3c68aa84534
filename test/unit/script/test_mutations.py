"""Damaged files are refused with findings, never with anything else."""

from __future__ import annotations

import random
import re

import pytest
from fakes.files_read import FILES, read, refusal
from fakes.profiles import PROFILE
from fakes.script_texts import mistakes
from fakes.shipped import ROOT

from bt_orchestrator.script.json_schema import SCHEMA_FILES

KEYS = {key.name for root in SCHEMA_FILES.values() for table in root.tree() for key in table.keys}

TRIES = 20_000 if PROFILE == 'nightly' else 100
"""Damaged copies of each file."""

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


@pytest.mark.parametrize('name', FILES)
def test_a_damaged_file_is_refused_in_words(name: str) -> None:
    text = (ROOT / name).read_text(encoding='utf-8')
    seed = name if PROFILE == 'gate' else random.randrange(2**32)
    chance = random.Random(seed)
    refused = 0
    for _ in range(TRIES):
        refused += refusal(name, mutated(text, chance)) is not None
    assert refused > TRIES // 2, seed


@pytest.mark.parametrize('name', FILES)
def test_a_misspelt_key_is_one_mistake(name: str) -> None:
    text = (ROOT / name).read_text(encoding='utf-8')
    keys = [entry for entry in re.finditer(r'\b[a-z_]{4,}(?=:)', text) if entry.group() in KEYS]
    assert keys
    for key in keys:
        word = key.group()
        damaged = text[: key.start()] + word[0] + word[2] + word[1] + word[3:] + text[key.end() :]
        findings = mistakes(lambda: read(name, damaged))  # noqa: B023 - called at once
        assert [f'did you mean `{word}`?' in entry for entry in findings] == [True], damaged
