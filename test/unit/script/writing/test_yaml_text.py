from __future__ import annotations

from typing import Any

import pytest
from fakes.profiles import examples
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.writing.yaml_text import WIDTH, entry, flow, scalar
from bt_orchestrator.script.yaml_nodes import as_data

TEXTS = st.text(st.characters(codec='utf-8'), max_size=20)
SCALARS = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    TEXTS,
    st.sampled_from(('true', 'null', '~', '010', '4.10', '1e5', '<<', '- a', '# b', 'a: b', "'")),
)
DATA = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=9), st.dictionaries(TEXTS, inner, max_size=9)
    ),
)


def read(text: str) -> Any:
    report = Report('text')
    node = compose(text, report)
    assert report.findings == ()
    assert node is not None
    return as_data(node)


@examples(100, 5000)
@given(DATA)
def test_what_is_written_is_read_again(data: Any) -> None:
    actual = read('\n'.join(entry('key', data, '')))
    assert repr(actual) == repr({'key': data})


@pytest.mark.parametrize(
    ('value', 'text'),
    [
        ('TASK_A', 'TASK_A'),
        ('/unpacking/unpacking_action', '/unpacking/unpacking_action'),
        ('4.10', '"4.10"'),
        ('yes', '"yes"'),
        ('a "b" \\', '"a \\"b\\" \\\\"'),
        ('größer', 'größer'),
        ('two\nlines', '"two\\U0000000alines"'),
        (1e-05, '1.0e-05'),
        (4.0, '4.0'),
        (True, 'true'),
        ([1, {'a': 'b c'}], '[1, {a: "b c"}]'),
    ],
)
def test_value_is_written_as_people_write_it(value: Any, text: str) -> None:
    assert flow(value) == text


def test_long_collection_gets_one_line_per_part() -> None:
    long = ['x' * 60] * 3
    row = {'short': [1, 2], 'long': long}
    assert list(entry('row', row, '  ')) == [
        '  row:',
        '    short: [1, 2]',
        '    long:',
        *(f'      - {word}' for word in long),
    ]


def test_single_value_stays_on_one_line() -> None:
    text = 'a ' * WIDTH
    assert list(entry('key', text, '')) == [f'key: {scalar(text)}']
