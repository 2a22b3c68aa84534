"""What is made from the code is up to date, and says everything that it has to."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import generate
import yaml
from fakes.shipped import ROOT

from bt_orchestrator.model.codec import event_types
from bt_orchestrator.ros.node_parameters import NodeParameters, described


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding='utf-8')


def test_generated_parts_are_up_to_date() -> None:
    assert list(generate.stale_files()) == [], 'run python docs/generate.py'


def test_every_generated_part_has_its_place() -> None:
    named = re.findall(r'<!-- generated: ([\w -]+) -->', ''.join(map(text_of, generate.PAGES)))
    assert sorted(named) == sorted(generate.PARTS)


def test_every_rule_of_the_line_has_tests() -> None:
    text = text_of('docs/semantics.md')
    chapters = re.findall(r'^## ([3-7])\. .*?\n(.*?)(?=^## )', text, re.MULTILINE | re.DOTALL)
    rules = {
        f'{chapter}.{rule}'
        for chapter, body in chapters
        for rule in re.findall(r'^(\d+)\. ', body, re.MULTILINE)
    }
    assert len(rules) > 20
    assert rules <= set(re.findall(r'^\| (\d\.\d+) \|', text, re.MULTILINE))


def test_a_stale_part_would_be_seen(tmp_path: Path) -> None:
    schemas = [f'schemas/{path.name}' for path in (ROOT / 'schemas').iterdir()]
    for name in (*generate.PAGES, *schemas):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text_of(name), encoding='utf-8')
    assert generate.stale_files(tmp_path) == {}
    page = tmp_path / 'docs' / 'events.md'
    text = page.read_text(encoding='utf-8')
    page.write_text(text.replace('| `task.started` |', '| `task.begun` |'), encoding='utf-8')
    schema = tmp_path / 'schemas' / 'cell.schema.json'
    schema.write_text(schema.read_text(encoding='utf-8').replace('30', '31'), encoding='utf-8')
    assert {*generate.stale_files(tmp_path)} == {'docs/events.md', 'schemas/cell.schema.json'}


AGREED = {
    'belt': 'index_started indexed',
    'cell': 'state_changed',
    'cycle': 'started completed',
    'flag': 'raised lowered',
    'hold': 'raised released',
    'item': 'placed moved rejected removed',
    'job': 'queued started completed aborted',
    'operator': 'decided',
    'task': 'started succeeded failed retrying skipped',
}
"""The events that other programs were promised."""


def test_additional_events_have_their_reason_recorded() -> None:
    agreed = {f'{part}.{name}' for part, names in AGREED.items() for name in names.split()}
    table = text_of('docs/decisions/0007-additional-events.md')
    added = set(re.findall(r'^\| `(\S+)` \|', table, re.MULTILINE))
    assert agreed | added == set(event_types())


# --- node parameters ------------------------------------------------------------------------

PARAMETER_FILE = 'config/tree_node.yaml'


def test_parameter_file_names_every_node_parameter() -> None:
    below = text_of(PARAMETER_FILE).partition('ros__parameters:\n')[2]
    named = re.findall(r'^    (?:# )?(\w+): ', below, re.MULTILINE)
    assert named == [*(name for name, _ in described()), *default_stream()]


def test_the_parameter_file_has_the_defaults() -> None:
    defaults = NodeParameters()
    for name, value in parameter_file().items():
        if name not in default_stream():
            assert value == (getattr(defaults, name) or value.__class__()), name


def parameter_file() -> dict[str, Any]:
    parameters: dict[str, Any] = yaml.safe_load(text_of(PARAMETER_FILE))['/**']['ros__parameters']
    return parameters


def default_stream() -> list[str]:
    """Return the names of a table that cannot be imported without ROS 2."""
    source = text_of('bt_orchestrator/ros/inspection/snapshot_streams.py')
    return re.findall(r"^    '(\w+)': \(", source, re.MULTILINE)
