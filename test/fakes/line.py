"""Small cells and scripts, run by the real engine in virtual time.

A cell of S sections has for every section n the components `an` and `bn`, further an `arm` that
serves sections 2 and 3, and a `lamp` of no section. A task takes 1 s and a move of the belt 2 s.
In the text of a script `@a2` stands for `task: TASK_A, action: /a2/do` and `@a2.TASK_B` names
another task. A line is empty at time 0 and starts by itself.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from textwrap import dedent, indent
from typing import Any

from fakes.action_types import FakeActionTypes
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.fault import parse_fault
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

TYPES = FakeActionTypes()
TASKS = ('PREPARE', 'TASK_A', 'TASK_B', 'TASK_C')
COMPONENT_TYPE = 'bt_orchestrator_interfaces/action/Component'

THREE = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}]
  3: [{id: pack, @a3, qty_change: -1}]
"""
"""The shortest line: item n is placed, worked on and packed."""


class Line:
    """A cell for tests."""

    def __init__(
        self,
        sections: int = 3,
        *,
        seconds: Mapping[str, float] | None = None,
        faults: Mapping[str, str] | None = None,
        topics: tuple[str, ...] = (),
        results: Mapping[str, Mapping[str, Any]] | None = None,
        belt: str = '',
        keys: Mapping[str, str] | None = None,
    ) -> None:
        """Describe the cell.

        :param seconds: how long every task of a component takes
        :param faults: faults of a component, separated by blanks
        :param topics: components with a state topic
        :param results: result fields of every task of a component
        :param belt: further keys of the conveyor, in YAML
        :param keys: further keys of a component, in YAML
        """
        named = [f'{letter}{n}' for n in range(1, sections + 1) for letter in 'ab']
        places = {name: name[1:] for name in named}
        if sections > 2:
            places['arm'] = '[2, 3]'
        places['lamp'] = ''
        text = [_belt(sections, belt), 'components:']
        more = keys or {}
        text += [
            _component(name, place, name in topics, more.get(name, ''))
            for name, place in places.items()
        ]
        self.text = '\n'.join(text)
        """The cell file, without what the other arguments say."""
        cell = parse_cell(self.text, 'cell.yaml', TYPES)
        self.types = TYPES
        self.cell = _adapted(cell, seconds or {}, faults or {}, results or {})

    def script(self, text: str, name: str = 'test') -> Script:
        """Read a script for this cell."""
        whole = f'script: {name}\n{dedent(text)}'
        return parse_script(expanded(whole), f'{name}.yaml', self.cell, TYPES)

    def begin(
        self,
        text: str = THREE,
        quantity: int = 1,
        *,
        auto_start: bool = True,
        **params: object,
    ) -> VirtualRun:
        """Queue one job `J` at time 0 and let it begin."""
        run = VirtualRun(self.cell, TYPES, auto_start=auto_start)
        run.submit('J', self.script(text), quantity, **params)
        return run

    def run(self, text: str = THREE, quantity: int = 1, **params: object) -> VirtualRun:
        """Run one job `J` until nothing more can happen."""
        return self.begin(text, quantity, auto_start=True, **params).go()


def with_section(number: int, tasks: str) -> str:
    """Return the shortest line with another list for one section, in YAML."""
    block = f'  {number}:\n' + indent(dedent(tasks).strip('\n'), '    ')
    return re.sub(rf'(?m)^  {number}: .*$', lambda _: block, THREE)


def with_initialization(text: str, more: str = '') -> str:
    """Return the shortest line with an initialization, in YAML."""
    sections = THREE.strip('\n')
    return f'initialization: {text}\n{more}{sections}'


def expanded(text: str) -> str:
    """Return a text with tasks in place of their short form."""
    return re.sub(
        r'@(\w+)(?:\.(\w+))?', lambda m: f'task: {m[2] or "TASK_A"}, action: /{m[1]}/do', text
    )


def _belt(sections: int, more: str) -> str:
    keys = {
        'sections': str(sections),
        'action': '/belt/do',
        'type': 'bt_orchestrator_interfaces/action/Conveyor',
        'task': 'MOVE_ONE_INDEX',
        'duration': '2.0',
    }
    listed = ', '.join(f'{key}: {value}' for key, value in keys.items())
    return f'cell: test_line\nconveyor: {{{listed}{", " + more if more else ""}}}'


def _component(name: str, sections: str, has_topic: bool, more: str) -> str:
    section = f'section: {sections}, ' if sections else ''
    state = ''
    if has_topic:
        topic = f'topic: /{name}/state, type: std_msgs/msg/String, field: data, ready: [READY]'
        state = f', state: {{{topic}}}'
    keys = f', {more}' if more else ''
    return f'  {name}: {{{section}action: /{name}/do, type: {COMPONENT_TYPE}{state}{keys}}}'


def _adapted(
    cell: Cell,
    seconds: Mapping[str, float],
    faults: Mapping[str, str],
    results: Mapping[str, Mapping[str, Any]],
) -> Cell:
    components = dict(cell.components)
    for name, time_s in seconds.items():
        durations = dict.fromkeys(TASKS, time_s)
        components[name] = replace(components[name], durations_s=durations)
    for name, specs in faults.items():
        parsed = tuple(parse_fault(spec) for spec in specs.split())
        components[name] = replace(components[name], faults=parsed)
    for name, fields in results.items():
        components[name] = replace(components[name], results=dict.fromkeys(TASKS, fields))
    conveyor = replace(cell.conveyor, component=components['conveyor'])
    return replace(cell, conveyor=conveyor, components=components)
