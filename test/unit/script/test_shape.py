"""What is in a file that is none of the user's files stays there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import mistakes, script

from bt_orchestrator.script.cell_file import file_kind, parse_cell
from bt_orchestrator.script.orders.order_file import parse_order

STRANGERS = {
    'accounts': 'hunter2:$6$secret$0a1b2c:19700:0:99999:7:::\ndaemon:*:19700:0:99999:7:::\n',
    'settings': 'password: hunter2\ntoken: 0a1b2c\nsecrets: [hunter2]\n',
    'twice': 'password: hunter2\npassword: 0a1b2c\n',
    'tags': 'password: !hunter2 0a1b2c\n',
    'alias': 'password: *hunter2\n',
    'anchors': 'a: &hunter2 [*hunter2]\n',
    'broken': 'password: "hunter2\ntoken: [0a1b2c\n',
    'tabs': 'password:\thunter2\n\ttoken:\t0a1b2c\n',
    'json': '{"password": "hunter2", "token": "0a1b2c"}',
    'broken json': '{"password": "hunter2" "token": "0a1b2c"}',
    'list': '- hunter2\n- {password: 0a1b2c, password: hunter2}\n',
    'documents': 'hunter2: 1\n---\npassword: 0a1b2c\n',
    'log': '6,123,0,-;hunter2: 0a1b2c\n',
    'control': 'hunter2\x00\x01',
    'nested': 'stages: [hunter2]\njob:\n  script: [0a1b2c]\n',
    'key': '? [hunter2]\n: 0a1b2c\n',
}
SECRETS = ('hunter2', '0a1b2c', 'password', 'token', 'daemon', '\x01', 'U+0000')

READERS: dict[str, Callable[[str], object]] = {
    'script': script,
    'cell file': lambda text: parse_cell(text, 'file.yaml', FakeActionTypes()),
    'work order': lambda text: parse_order(text, 'file.yaml'),
}


@pytest.mark.parametrize('kind', READERS)
@pytest.mark.parametrize('name', STRANGERS)
def test_of_what_is_something_else_nothing_is_told(kind: str, name: str) -> None:
    (finding,) = mistakes(lambda: READERS[kind](STRANGERS[name]))
    assert finding.startswith(f'1:1: this is not a {kind}, but ')
    assert not [word for word in SECRETS if word in finding]


@pytest.mark.parametrize('name', STRANGERS)
def test_file_kind_detection_reveals_no_content(name: str, tmp_path: Path) -> None:
    path = tmp_path / 'file.yaml'
    path.write_text(STRANGERS[name])
    (finding,) = mistakes(lambda: file_kind(path))
    assert 'this is not a cell file or a script, but ' in finding
    assert not [word for word in SECRETS if word in finding]


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('scrpt: a\n', 'did you mean `script`?'),
        ('sectons: {}\n', 'did you mean `sections`?'),
        ('  script: a\n  stray: 1\n', 'has no key `stray`'),
        ('{script: a, stray: 1}', 'has no key `stray`'),
        ('# of mine\n---\nscript: a\nsections: [\n', 'this is not YAML: '),
        ('\ufeffscript: a\n"sections": {1: "}\n', 'this is not YAML: '),
        ('{"quantity": 1, "script": "a" "b"}', 'this is not YAML: '),
        ('{}', 'a script needs the key `script`'),
        ('', 'the file is empty'),
        ('# nothing\n', 'the file is empty'),
    ],
)
def test_faulty_script_is_checked_as_a_script(text: str, expected: str) -> None:
    assert any(expected in finding for finding in mistakes(lambda: script(text)))


KINDS = {
    'a cell file': 'cell: a\nconveyor: {sections: 1}\ncomponents: {}\n',
    'a script': 'script: a\nsections: {1: []}\n',
    'a work order': 'order: A\nscript: a\nquantity: 2\n',
}


@pytest.mark.parametrize('expected', READERS)
@pytest.mark.parametrize('kind', KINDS)
def test_wrong_file_kind_is_reported_in_one_line(expected: str, kind: str) -> None:
    findings = mistakes(lambda: READERS[expected](KINDS[kind]))
    hint = 'check which file is named'
    if (expected, kind) == ('work order', 'a script'):
        hint = 'name a file with `script: a` and `quantity`'
    is_so = [f'1:1: this is {kind}, and a {expected} is expected; {hint}']
    assert (findings == is_so) == (kind != f'a {expected}')
