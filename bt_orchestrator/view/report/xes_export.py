"""Export of records for process mining: an event log in XES (IEEE 1849-2016).

One trace an item, for an item is what goes through the process; job and script are attributes of
the trace. An activity is a task; its attempts are told apart by `concept:instance`, the goal UUID.
Initialization and moves of the belt belong to no item and are not in the log.

Times go on as the clock did at the first record, also where it was set: programs take durations
from them. An event after that has the time that the clock showed beside it, as `clock`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import IO, Any
from xml.sax.saxutils import quoteattr

from bt_orchestrator.model.codec import json_of, known_event
from bt_orchestrator.model.events import TaskEvent
from bt_orchestrator.model.task_spans import TaskSpans
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.steady_time import STEPS, SteadyTime
from bt_orchestrator.view.report.csv_export import iso_time

_HEAD = """\
<?xml version="1.0" encoding="UTF-8"?>
<log xes.version="1849.2016" xes.features="" xmlns="http://www.xes-standard.org/">
  <extension name="Concept" prefix="concept" uri="http://www.xes-standard.org/concept.xesext"/>
  <extension name="Lifecycle" prefix="lifecycle" \
uri="http://www.xes-standard.org/lifecycle.xesext"/>
  <extension name="Time" prefix="time" uri="http://www.xes-standard.org/time.xesext"/>
  <extension name="Organizational" prefix="org" uri="http://www.xes-standard.org/org.xesext"/>
  <global scope="trace">
    <string key="concept:name" value=""/>
    <string key="job" value=""/>
  </global>
  <global scope="event">
    <string key="concept:name" value=""/>
    <string key="lifecycle:transition" value="complete"/>
    <date key="time:timestamp" value="1970-01-01T00:00:00.000000+00:00"/>
  </global>
  <classifier name="Activity" keys="concept:name"/>
  <classifier name="ActivityAndLifecycle" keys="concept:name lifecycle:transition"/>
  <string key="concept:name" value="bt_orchestrator"/>
  <string key="lifecycle:model" value="standard"/>
"""

_TRANSITIONS: Mapping[str, str] = {
    'task.started': 'start',
    'task.adopted': 'resume',
    'task.succeeded': 'complete',
    'task.marked_done': 'complete',
    'task.failed': 'ate_abort',
    'task.retrying': 'schedule',
    'task.skipped': 'autoskip',
}
"""The transition of each task event in the standard life cycle."""

_OF_JOB = ('script', 'recipe', 'recipe_version')

_KEPT = ('section', 'round', 'attempt', 'action', 'reason', 'message')
"""Fields that become attributes of the event."""


class XesExport:
    """Collects the traces and writes them at the end: events of many items come interleaved."""

    at_end = True

    def __init__(self, file: IO[str]) -> None:
        """Begin; without `take_steps` the records alone say how the clock was set."""
        self._file = file
        self._steady = SteadyTime()
        self._ahead_us: int | None = None
        """How far the clock was ahead at the first record."""
        self._traces: dict[str, list[str]] = {}
        self._attributes: dict[str, dict[str, Any]] = {}
        self._jobs: dict[str, dict[str, Any]] = {}
        """The facts of the job of an item."""
        self._spans = TaskSpans()

    def take_steps(self, steady: SteadyTime) -> None:
        """Take what is known of the steps of the clock; called before the first record."""
        self._steady = steady

    def write(self, text: str) -> None:
        """Take in one record."""
        record = json.loads(text)
        name = record['event']
        self._take_time(record)
        if name in ('job.queued', 'job.updated'):
            self._jobs[record['job']] = {k: record[k] for k in _OF_JOB if k in record}
        if 'item' not in record or 'job' not in record:
            return
        if name == 'item.removed':
            self._attributes_of(record)['outcome'] = record['how']
        if name == 'item.identified':
            self._attributes_of(record)['serial'] = record['serial']
        if name == 'item.placed':
            lots = record.get('lots', {}).items()
            self._attributes_of(record).update({f'lot:{key}': lot for key, lot in lots})
        if name == 'item.missing':
            self._attributes_of(record)['outcome'] = 'missing'
        if name in _TRANSITIONS:
            self._traces.setdefault(record['item'], []).append(self._event(record))
            self._attributes_of(record)

    def close(self) -> None:
        """Write the log."""
        self._file.write(_HEAD)
        for item, events in self._traces.items():
            self._file.write('  <trace>\n')
            attributes = self._attributes[item]
            self._file.write(''.join(_attribute(k, v, 4) for k, v in attributes.items()))
            self._file.write(''.join(events))
            self._file.write('  </trace>\n')
        self._file.write('</log>\n')

    def _attributes_of(self, record: Mapping[str, Any]) -> dict[str, Any]:
        item, job = record['item'], record['job']
        if item not in self._attributes:
            about = self._jobs.get(job, {'script': ''})
            self._attributes[item] = {'concept:name': item, 'job': job, **about}
        return self._attributes[item]

    def _event(self, record: Mapping[str, Any]) -> str:
        attributes: dict[str, Any] = {'concept:name': record['task']}
        goal = record.get('goal')
        if goal is not None:
            attributes['concept:instance'] = goal
        component = self._component(record)
        if goal is not None and component is not None:
            attributes['org:resource'] = component
        attributes['lifecycle:transition'] = _transition(record)
        attributes |= {name: record[name] for name in _KEPT if name in record}
        if record.get('results'):
            attributes['results'] = json_of(record['results'])
        dates = {'time:timestamp': self._time(record)}
        if dates['time:timestamp'] != iso_time(record['time']):
            dates['clock'] = iso_time(record['time'])
        lines = ''.join(_attribute(key, value, 6) for key, value in attributes.items())
        lines += ''.join(f'      <date key="{k}" value="{v}"/>\n' for k, v in dates.items())
        return f'    <event>\n{lines}    </event>\n'

    def _take_time(self, record: Mapping[str, Any]) -> None:
        if record['seq'] > self._steady.known:
            event = known_event(record) if record['event'] in STEPS else None
            if event is not None:
                self._steady.follow(event)
        if self._ahead_us is None:
            self._ahead_us = self._steady.ahead_of(record['seq'])

    def _time(self, record: Mapping[str, Any]) -> str:
        ahead_us = self._steady.ahead_of(record['seq']) - (self._ahead_us or 0)
        return iso_time(record['time'] - ahead_us / US if ahead_us else record['time'])

    def _component(self, record: Mapping[str, Any]) -> str | None:
        """Return the component that works at a task: the start of an attempt names it."""
        event = known_event(record)
        if not isinstance(event, TaskEvent):
            return None
        ended = self._spans.follow(event)
        started = self._spans.start_of(event) if ended is None else ended.started
        return None if started is None else started.component


def _transition(record: Mapping[str, Any]) -> str:
    by_hand = record['event'] == 'task.skipped' and ' decided ' in record.get('reason', '')
    return 'manualskip' if by_hand else _TRANSITIONS[record['event']]


def _attribute(key: str, value: Any, indent: int) -> str:
    kind = 'int' if isinstance(value, int) else 'string'
    return f'{" " * indent}<{kind} key={quoteattr(key)} value={quoteattr(_xml(str(value)))}/>\n'


def _xml(text: str) -> str:
    """Return a text without characters that XML 1.0 cannot carry, whatever a device sent."""
    return _NOT_XML.sub('\N{REPLACEMENT CHARACTER}', text)


_NOT_XML = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
"""Characters outside production 2 of XML 1.0."""
