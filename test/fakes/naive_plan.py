"""What the naive cell is given: the controllers and scripts of a drawn line."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from itertools import chain
from math import ceil, inf, isnan, nan
from types import SimpleNamespace
from typing import Any

Row = dict[str, Any]

CHECK_S, CHECKS_OF_A_REQUEST = 2.0, 2
REASONS = {'abort': 'aborted', 'cancel': 'canceled', 'false': 'task_result_false'}


class NaiveDevice:
    """A controller and what it does with goals (docs/cell_file.md; faults like `#2=late:3.3`)."""

    def __init__(
        self, name: str, given: Row, sections: range, duration: Callable[[str, int], float | None]
    ) -> None:
        self.name, self.given, self.duration = name, given, duration
        place = given.get('section', [])
        self.places = (place if isinstance(place, list) else [place]) or list(sections)
        self.faults = dict(text[1:].split('=') for text in given.get('faults', []))
        self.goals, self.accepted, self.dead = 0, 0, False
        self.read: float | None = None

    def take(self, task: str) -> tuple[float, list[tuple[float, str, float]]]:
        """Take a goal.

        :return: the seconds after which it is deaf to a cancel, and how it ends if left alone:
            after so many seconds, with a reason ('': it succeeds), and the seconds after which
            that is certain
        """
        self.goals += 1
        kind, _, extra_s = self.faults.get(str(self.goals), '').partition(':')
        if self.dead or kind == 'reject':
            return 0.0, [(0.0, 'goal_rejected', 0.0)]
        if kind == 'mute':
            return 0.0, [(CHECK_S * CHECKS_OF_A_REQUEST, 'server_lost', 0.0)]
        self.accepted += 1
        seconds = self.duration(self.name, self.accepted)
        if seconds is None:
            seconds = self.given.get('durations', {}).get(task, self.given.get('duration', 1.0))
        if kind == 'die':
            back = seconds / 2 + float(extra_s)
            lost = CHECK_S * max(1, ceil(back / CHECK_S))
            return seconds / 2, [(lost, 'server_lost', back)]
        if kind in ('hang', 'ignore_cancel'):
            self.dead = kind == 'ignore_cancel'
            return 0.0 if self.dead else inf, []
        self.read = float(extra_s or nan) if kind == 'reads' else None
        late_s = float(extra_s or 0) if kind == 'late' else 0.0
        return inf, [(seconds + late_s, REASONS.get(kind, ''), 0.0)]

    def results(self, task: str) -> Row:
        """Return the results of a task that succeeded."""
        own = self.given.get('results', {}).get(task, {})
        if task == 'READ':
            number = self.goals if self.read is None or isnan(self.read) else int(self.read)
            return {'serial': own['serial'].replace('{n}', str(number))}
        fields = {'item_present': True, 'measurement': 0.0, **own}
        if self.read is not None:
            fields['measurement'] = self.read
        return {} if self.name == 'conveyor' else fields


def requires_conveyor(task: Row) -> bool:
    return bool(task.get('requires_conveyor', True))


def plan_of(script: Row) -> SimpleNamespace:
    """Return a script: lists of steps, steps as lists of members, members as lists of tasks."""
    lists, early, trailing, repeats = {}, set(), set(), {}
    for number, given in script['sections'].items():
        whole = given if isinstance(given, dict) else {'tasks': given}
        steps = [step.get('parallel', [step]) for step in whole['tasks']]
        for member in [m for step in steps for m in step if 'repeat' in m]:
            repeats[member['repeat'][0]['id']] = member.get('times', 1)
        lists[number] = [
            [m if isinstance(m, list) else m.get('repeat', [m]) for m in step] for step in steps
        ]
        if whole.get('release_conveyor') == 'after_last_conveyor_task':
            early.add(number)
            needs = [any(map(requires_conveyor, chain(*step))) for step in lists[number]]
            behind = lists[number][len(needs) - needs[::-1].index(True) :]
            trailing |= {task['id'] for step in behind for task in chain(*step)}
    flags, changes = script.get('lateral_dependencies', []), defaultdict(list)
    for side, step in (('upstream', 1), ('downstream', -1)):
        for link in flags:
            changes[link[side]].append((link['flag'], step, link['capacity']))
    placed = [(n, t) for n, steps in lists.items() for step in steps for m in step for t in m]
    return SimpleNamespace(
        name=script['script'],
        made_from=script.get('made_from', {}),
        lists=lists,
        early=early,
        trailing=trailing,
        source=next(number for number, task in placed if task.get('qty_change') == 1),
        sink=max(number for number, task in placed if task.get('qty_change') == -1),
        flags=flags,
        changes=changes,
        zones=script.get('zones', {}),
        repeats=repeats,
        lots=script.get('lots', {}),
        limit=script.get('hold_after'),
        asks=script.get('first_piece', False),
        first=script.get('initialization', []),
        order=script.get('initialization_dependencies', []),
    )


def imply(plan: SimpleNamespace, devices: dict[str, NaiveDevice]) -> None:
    """Add the changes that the tasks of a script imply to its initialization (5.3.2, 5.3.4)."""
    own, implied = list(plan.first), dict[str, Row]()
    for number in sorted(plan.lists):
        touched: set[tuple[str, str]] = set()
        for given in [t for step in plan.lists[number] for member in step for t in member]:
            device = devices[given['action']]
            for setup, value in given.get('setup', {}).items():
                made = device.given['changes'][setup]
                change = {'id': f'{device.name}.{setup}.{value}', 'task': made['task']}
                change |= {'action': given['action'], 'args': {made['argument']: value}}
                late = (device.name, setup) in touched
                before = implied.setdefault(change['id'], {**change, 'late': late})
                before['late'] &= late
                touched.add((device.name, setup))
            changed = change_of(device, given)
            if changed:
                touched.add((device.name, changed[0]))
    for change in implied.values():
        first = [task['id'] for task in own if task['action'] == change['action']]
        plan.order = [*plan.order, *({'upstream': u, 'downstream': change['id']} for u in first)]
    plan.first = [*own, *implied.values()]


def change_of(device: NaiveDevice, given: Row) -> tuple[str, str] | None:
    """Return the setup and the value that a task changes, if it does."""
    for setup, made in device.given.get('changes', {}).items():
        if made['task'] == given['task']:
            return setup, given['args'][made['argument']]
    return None
