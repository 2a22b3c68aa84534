"""What a node makes of a damaged journal, and whether that is right."""

from __future__ import annotations

import json
import traceback
from enum import Enum
from pathlib import Path
from typing import NamedTuple

from damage.kinds import Case, damage
from damage.scene import NAME, frozen
from fakes.action_types import FakeActionTypes
from fakes.commands import AnswerHold, Resume
from fakes.journal_reading import journal_reading
from fakes.line import Line
from fakes.operator import ann

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.sim.gateway import VirtualClock, VirtualGateway
from bt_orchestrator.store.sqlite.store import SqliteStore

CELL = Line().cell
MOST_STEPS = 2000
"""A line that still has jobs after so many steps is stuck."""


class Verdict(Enum):
    """What the node did."""

    SAME = 'same'
    HELD = 'told and held'
    REFUSED = 'refused'
    SILENT = 'silent'
    """It went on with another state, without a word."""
    FAULT = 'fault'
    """A traceback, a line that cannot go on, a refusal that changed a file, a false record."""


class Judgement(NamedTuple):
    """A verdict and what was said."""

    verdict: Verdict
    said: str


def judge(case: Case, folder: Path, seed: int) -> Judgement:
    """Damage the journal of a case in a new folder, and start a node on it."""
    path = case.scene.copy(folder)
    damage(case, path, seed)
    try:
        wrong = _misread(case, path)
        return Judgement(Verdict.FAULT, wrong) if wrong else _started(case, path)
    except Exception:  # noqa: BLE001 - whatever it is, it must not be
        return Judgement(Verdict.FAULT, traceback.format_exc())


def _started(case: Case, path: Path) -> Judgement:
    before = _files(path)
    try:
        store = SqliteStore(path)
        try:
            state = restore(CELL, store)
        except BaseException:
            store.close()
            raise
    except OrchestratorError as refused:
        if _files(path) != before:
            return Judgement(Verdict.FAULT, f'refused, but files were changed: {refused}')
        return Judgement(Verdict.REFUSED, str(refused))
    restored = frozen(state)
    true = case.scene.state_at(state.seq)
    whole = state.seq == case.scene.events[-1].seq
    report = _gone_on_with(store)
    store.close()
    if restored != true:
        return Judgement(Verdict.SILENT, f'a state that never was, at event {state.seq}: {report}')
    if report:
        return Judgement(Verdict.HELD, report)
    if whole:
        return Judgement(Verdict.SAME, '')
    return Judgement(Verdict.SILENT, f'the state of event {state.seq}')


def _gone_on_with(store: SqliteStore) -> str:
    """Let a node go on to the end of all jobs; returns what it said was missing."""
    clock = VirtualClock(1e6)
    gateway = VirtualGateway(CELL, FakeActionTypes(), clock)
    orchestrator = Orchestrator(CELL, gateway, clock, store, auto_resume=True)
    state = orchestrator.state
    kept = orchestrator.kept_seq
    orchestrator.settle()
    messages = [hold.message for hold in state.holds.values() if hold.reason == 'missing']
    started = len(state.running)
    for _ in range(MOST_STEPS):
        if _reason_to_stop(orchestrator):
            # Of a part that no start reads: the line is Held and says why, nothing more is sent.
            orchestrator.close()
            return '; '.join([*messages, _reason_to_stop(orchestrator)])
        for hold in list(state.holds.values()):
            by = ann('looked at it')
            offered = Resume(by, hold.id) if hold.is_pause else None
            answer = AnswerHold(hold.id, 'skip' if 'skip' in hold.answers else 'retry', by)
            done = orchestrator.ask(offered or answer)
            assert done.accepted, done.message
        orchestrator.settle()
        if _reason_to_stop(orchestrator):
            continue
        if not state.jobs or not (clock.advance() or state.holds):
            break
        orchestrator.settle()
    assert not state.jobs, f'stuck with {list(state.jobs)}, {started} goals at the start'
    # Those before may be damaged: a newer snapshot led past them.
    assert [event.seq for event in store.read(kept)] == list(range(kept + 1, state.seq + 1))
    again = restore(CELL, store)
    assert frozen(again) == frozen(state), 'the next start finds another state'
    orchestrator.close()
    return '; '.join(messages)


def _reason_to_stop(orchestrator: Orchestrator) -> str:
    return orchestrator.broken or ''


def _misread(case: Case, path: Path) -> str:
    """Read the journal as the verbs do; returns what is wrong with what they show."""
    reports: list[str] = []
    true = {event.seq: event for event in case.scene.events}
    try:
        with journal_reading(path, reports.append) as reader:
            list(reader.summaries())
            read = dict(reader.each(Wanted()))
    except OrchestratorError:
        return ''
    wrong = [seq for seq, text in read.items() if from_record(json.loads(text)) != true.get(seq)]
    if wrong:
        return f'shown, but never written: {wrong}'
    if len(read) < len(true) and not reports and case.ending != '-mark':
        return f'{len(true) - len(read)} events are not shown, and nothing is said'
    return ''


def _files(path: Path) -> dict[str, bytes]:
    return {
        file.name: file.read_bytes()
        for file in path.parent.glob(f'{NAME}*')
        if 'lock' not in file.name
    }
