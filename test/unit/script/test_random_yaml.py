"""Whatever a text is, it is read or refused: no traceback, no hang, little memory."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import pytest
import yaml
from fakes import little_memory
from fakes.files_read import KINDS, refusal
from fakes.profiles import examples
from hypothesis import example, given
from hypothesis import strategies as st

from bt_orchestrator.script.json_schema import SCHEMA_FILES

pytestmark = pytest.mark.timeout(24 * 3600)

KEYS = sorted(
    {k.name for root in SCHEMA_FILES.values() for table in root.tree() for k in table.keys}
)

TOKENS = st.sampled_from(
    (
        *('\n', '\n  ', '\n    ', '\n- ', '- ', ': ', ', ', ' ', '[', ']', '{', '}', '? ', '\t'),
        *(
            '&a ',
            '&b ',
            '*a',
            '*b',
            '<<: ',
            '|\n',
            '>-\n',
            '"',
            "'",
            '#',
            '---\n',
            '...\n',
            '%YAML',
        ),
        *(
            '!!str ',
            '!!set ',
            '!!python/name:os.system ',
            '!x ',
            '${',
            '}',
            '\\',
            '\x00',
            '\ufeff',
        ),
        *('0', '-1', '1e999', '.nan', '0x1F', 'null', 'true', '2024-01-01', 'ü', '\U0001f916'),
        *KEYS,
    )
)
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(('TASK_A', '/unpacking/unpacking_action', '${item.number}', '${results.a.b}')),
)
STRUCTURES = st.dictionaries(
    st.sampled_from(KEYS),
    st.recursive(
        SCALARS,
        lambda inner: st.one_of(
            st.lists(inner, max_size=4),
            st.dictionaries(
                st.one_of(st.sampled_from(KEYS), st.integers(-1, 9), st.text(max_size=4)),
                inner,
                max_size=5,
            ),
        ),
        max_leaves=20,
    ),
    max_size=8,
)


@examples(300, 10_000)
@given(st.sampled_from(KINDS), st.one_of(st.text(), st.lists(TOKENS, max_size=60).map(''.join)))
def test_random_text_is_read_or_refused_with_place(name: str, text: str) -> None:
    refusal(name, text)


@examples(100, 4_000)
@example('trees/reference_process.yaml', {'lots': {'\n': None}}, None)
@given(st.sampled_from(KINDS), STRUCTURES, st.sampled_from((None, True, False)))
def test_random_structure_is_read_or_refused_with_place(
    name: str, data: Any, flow: bool | None
) -> None:
    refusal(name, yaml.safe_dump(data, default_flow_style=flow, allow_unicode=True))


def test_hostile_texts_are_refused_in_little_memory() -> None:
    """In a process that the kernel gives no more (RLIMIT_AS)."""
    command = [sys.executable, little_memory.__file__]
    path = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    run = subprocess.run(command, capture_output=True, text=True, check=False, env=path)
    assert (run.returncode, run.stderr) == (0, '')
    assert run.stdout.splitlines() == [f'{name}: refused' for name in little_memory.BOMBS]
