"""What the simulated controllers of the naive cell do with a goal (docs/formats.md: faults)."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from typing import Any

from fakes.naive_plan import Row

CHECK_S, CHECKS_OF_A_REQUEST = 2.0, 2
REASONS = {'abort': 'aborted', 'cancel': 'canceled', 'false': 'task_result_false'}


class NaiveDevices:
    """All controllers, the conveyor's too."""

    def __init__(self, cell: Row, duration: Callable[[str, int], float | None]) -> None:
        self.by_action: dict[str, Row] = {}
        for name, found in {**cell['components'], 'conveyor': cell['conveyor']}.items():
            place = found.get('section', [])
            places = place if isinstance(place, list) else [place]
            self.by_action[found['action']] = {**found, 'name': name, 'places': places}
        self.duration = duration
        self.dead: set[str] = set()
        self.counts: Counter[Any] = Counter()

    def answers(self, task: Row, *, cancelled: bool) -> tuple[bool, list[tuple[float, str, int]]]:
        """Take a goal.

        :return: whether it is deaf to a cancel, and how it ends: after so many seconds, with a
            reason ('': it succeeds) and a rank among what happens at one time
        """
        name, device = task['device'], self.by_action[task['action']]
        if name in self.dead:
            return True, [(0.0, 'goal_rejected', -1)]
        kind, extra_s = self.fault(device, task['task'])
        if kind == 'reject':
            return False, [(0.0, 'goal_rejected', -1)]
        if kind == 'mute':
            return True, [(CHECK_S * CHECKS_OF_A_REQUEST, 'server_lost', 0)]
        self.counts[name, 'accepted'] += 1
        seconds = self.duration(name, self.counts[name, 'accepted'])
        if seconds is None:
            seconds = device.get('durations', {}).get(task['task'], device.get('duration', 1.0))
        if kind == 'ignore_cancel':
            self.dead.add(name)
            return True, []
        ends = [(0.0, 'canceled', 0)] if cancelled else []
        if kind == 'die':
            checks = -(-(seconds / 2 + extra_s) // CHECK_S)
            ends.append((CHECK_S * max(checks, 1), 'server_lost', 1))
        elif kind != 'hang':
            late_s = extra_s if kind == 'late' else 0.0
            ends.append((seconds + late_s, REASONS.get(kind, ''), 0))
        return False, ends

    def fault(self, device: Row, task: str) -> tuple[str, float]:
        """Return what strikes at the next goal, and its seconds; '' for none."""
        for key in (device['name'], (device['name'], task)):
            self.counts[key] += 1
        for text in device.get('faults', []):
            match = re.fullmatch(r'(\w*?)(?:#(\d+|\*))?=(\w+)(?::(.*))?', text)
            assert match is not None, text
            nth = self.counts[device['name'], task] if match[1] else self.counts[device['name']]
            if match[1] in ('', task) and (match[2] or '1') in ('*', str(nth)):
                return match[3], float(match[4] or 0.0)
        return '', 0.0

    def results(self, task: Row) -> Row:
        """Return the results of a task that succeeded."""
        if task['device'] == 'conveyor':
            return {}
        own = self.by_action[task['action']].get('results', {}).get(task['task'], {})
        return {'item_present': True, 'measurement': 0.0, **own}
