"""Local and remote, and manual mode: who moves the line, and from where (semantics 7.8, 7.11)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.cell_commands import IN_MANUAL
from bt_orchestrator.engine.runtime.deciding import (
    Decided,
    decides,
    not_allowed,
    not_from_there,
)
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.operators import released_with
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import Control
from bt_orchestrator.model.commands import Answer, Command
from bt_orchestrator.model.failures import raise_hold, will_hold
from bt_orchestrator.model.frozen import shared
from bt_orchestrator.model.goal import Contest, Reason
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.judging.belt_statement import believed, corrections
from bt_orchestrator.model.line import waits_for_readiness, waits_for_service
from bt_orchestrator.model.packml import MANUAL_FROM, UnitMode
from bt_orchestrator.model.requests import (
    AT_PANEL,
    CANCEL_TASK,
    CONTROLS,
    RUN_TASK,
    UNIT_MODES,
    Asked,
)
from bt_orchestrator.model.script import manual_task
from bt_orchestrator.model.state import CellState, Hold, Phase
from bt_orchestrator.model.status import ManualGoal
from bt_orchestrator.model.words import sentence

SILENT_S = 2.0
"""Seconds after which a goal is cancelled whose panel was not heard any more."""

PANEL_LOST, CANCELLED = 'panel_lost', 'cancel_task'
"""Causes of a cancel."""

_HEARD = sentence('heard')

_LEAVE = UNIT_MODES[UnitMode.PRODUCTION]


@decides(*CONTROLS.values())
def _hand_over(state: CellState, asked: Asked, _: float) -> Decided:
    """Change from where the line may be moved; nothing stops, and nothing starts (7.8)."""
    control = Control(asked.request.word)
    if state.unit_mode is UnitMode.MANUAL and control is Control.REMOTE:
        name = asked.request.name
        raise CommandRefused(sentence('refused_because', request=name, words=IN_MANUAL))
    if state.control is control:
        raise CommandRefused(sentence('control_already', control=control.value))
    return _HANDED_OVER[control], [e.ControlChanged(control=control.value, reason=str(asked.by))]


_HANDED_OVER = {
    Control.LOCAL: sentence('now_local'),
    Control.REMOTE: sentence('now_remote'),
}


@decides(UNIT_MODES[UnitMode.MANUAL])
def _enter(state: CellState, asked: Asked, _: float) -> Decided:
    """Let the cell stand; nothing stops, because nothing runs.

    :raises CommandRefused: it works, or has items on the belt
    """
    if state.unit_mode is UnitMode.MANUAL:
        raise CommandRefused(sentence('manual_already'))
    if state.packml not in MANUAL_FROM or state.running:
        named = ' or '.join(allowed.value for allowed in MANUAL_FROM)
        raise CommandRefused(sentence('no_manual_here', state=state.packml.value, states=named))
    if any(item.section and item.present for item in state.items.values()):
        raise CommandRefused(sentence('items_on_belt', belt=believed(state)))
    mode = e.UnitModeChanged(mode=UnitMode.MANUAL.value, reason=str(asked.by))
    return sentence('now_manual'), [mode]


@decides(_LEAVE)
def _leave(state: CellState, asked: Asked, _: float) -> Decided:
    """End manual mode, with a statement of the belt as after an abort.

    :raises CommandRefused: a goal runs or is in doubt, or the belt is not as it was stated
    """
    _check_manual(state)
    if e.MANUAL_KEY in state.running:
        raise CommandRefused(sentence('manual_goal_runs'))
    held = _own_hold(state)
    if held is not None:
        raise CommandRefused(_of_goal('manual_goal_open', state, held=hold_name(held)))
    gone = list(corrections(state, asked['belt']))
    return sentence('manual_over'), chain(
        (
            event
            for correction in gone
            for event in (correction, *released_with(state, correction.item))
        ),
        [e.UnitModeChanged(mode=UnitMode.PRODUCTION.value, reason=str(asked.by))],
    )


@decides(RUN_TASK)
def _run(state: CellState, asked: Asked, _: float) -> Decided:
    """Let one goal be sent; `Panel.land` sends it.

    :raises CommandRefused: another one runs, or something speaks against the component
    """
    _check_manual(state)
    component, hold = asked['component'], asked.arguments.get('hold', '')
    why_not = _why_not_now(state) or _why_not_there(state, component, hold)
    if why_not:
        raise CommandRefused(sentence('no_goal', component=component, words=why_not))
    goal = e.ManualAsked(
        component=component,
        name=asked['task'],
        args=asked.arguments.get('args', {}),
        who=asked.sender.who,
        known=asked.sender.known.value,
        reason=asked.sender.reason,
        hold=hold,
    )
    return sentence('task_sent', task=asked['task'], component=component), [goal]


@decides(CANCEL_TASK)
def _cancel(state: CellState, asked: Asked, _: float) -> Decided:
    run, running = state.manual, state.running.get(e.MANUAL_KEY)
    if run is None or running is None or run.component != asked['component']:
        raise CommandRefused(sentence('no_manual_goal', component=asked['component']))
    if running.cancel_cause is not None:
        raise CommandRefused(_of_goal('manual_goal_ends', state))
    message = _of_goal('task_cancelled', state)
    return message, effects.cancelled(state, [e.MANUAL_KEY], CANCELLED)


@decides(AT_PANEL)
def _at_panel(state: CellState, _: Asked, __: float) -> Decided:
    """Refuse what `Panel.hear` did not take."""
    _check_manual(state)
    return _HEARD, ()


def _check_manual(state: CellState) -> None:
    if state.unit_mode is not UnitMode.MANUAL:
        raise CommandRefused(sentence('not_in_manual'))


def _of_goal(kind: str, state: CellState, **values: object) -> str:
    """Return a sentence about the goal of manual mode."""
    run = state.manual
    assert run is not None
    return sentence(kind, task=run.name, component=run.component, **values)


# --- what speaks against a goal -----------------------------------------------------------------


def _why_not_now(state: CellState) -> str:
    """Say what keeps every component from a goal of manual mode; empty: nothing does."""
    if state.packml not in MANUAL_FROM:
        return sentence('cell_is', state=state.packml.value)
    if e.MANUAL_KEY in state.running:
        return _of_goal('one_manual_goal', state)
    held = _own_hold(state) or next(iter(state.stops), None)
    return sentence('hold_open', held=hold_name(held)) if held is not None else ''


def _why_not_there(state: CellState, component: str, named: str) -> str:
    """Say what keeps a component from a goal; empty: nothing does."""
    contest = state.contests.get(component)
    wait = waits_for_service(state, component) or waits_for_readiness(state, component)
    if wait is not None:
        return wait.reason
    if contest:
        return contest.words(state.cell.components[component].action)
    keepers = list(_keepers(state, component))
    kept = next(filter(None, (_why_kept(state, key, named) for key in keepers)), '')
    if not kept and named and named not in {state.tasks[key].hold for key in keepers}:
        return sentence('hold_keeps_not', hold=named)
    return kept or _why_zone_kept(state, component, named)


def _keepers(state: CellState, component: str) -> Iterator[e.TaskKey]:
    """Yield the tasks that keep a component; the belt is kept by each that needs it at rest."""
    if component in state.reserved:
        yield state.reserved[component]
    if component != state.cell.conveyor.component.name:
        return
    for name, key in state.reserved.items():
        task = state.task(key)
        if name != component and task is not None and key.section and task.requires_conveyor:
            yield key


def _why_kept(state: CellState, key: e.TaskKey, named: str) -> str:
    """Say why a task that keeps a component is not passed over; empty: it is."""
    task = state.tasks[key]
    hold = state.holds.get(task.hold or '')
    if hold is None:
        return sentence('kept', task=key)
    if _is_in_doubt(hold, task.never_begun):
        return sentence('kept_in_doubt', held=hold_name(hold))
    return '' if hold.id == named else sentence('kept_by_hold', held=hold_name(hold))


def _is_in_doubt(hold: Hold, never_begun: bool) -> bool:
    """Tell whether the goal of a held task may still go on (2.4).

    After an abort its server may have said that it has ended.
    """
    if never_begun or any(words.kind in _ENDED for words in hold.message_words):
        return False
    return hold.reason in (Reason.IN_DOUBT.value, Reason.SERVER_LOST.value)


_ENDED = frozenset(('after_abort_canceled', 'after_abort_aborted'))


def _why_zone_kept(state: CellState, component: str, named: str) -> str:
    """Say which zone, in which a component works, another task keeps; empty: none."""
    zones = {
        zone
        for script in state.scripts.values()
        for task, inside in script.zones_of.items()
        for zone in inside
        if script.tasks[task].component == component
    }
    for zone in sorted(zones & state.zones.keys()):
        key = state.zones[zone]
        hold = state.tasks[key].hold
        if hold is None or hold != named:
            kind = 'kept_zone_held' if hold else 'kept_zone'
            return sentence(kind, task=key, zone=zone, hold=hold)
    return ''


# --- the goal, and its panel --------------------------------------------------------------------


def _own_hold(state: CellState) -> Hold | None:
    """Return the hold of a goal of manual mode that is in doubt."""
    return next((hold for hold in state.holds.values() if hold.key == e.MANUAL_KEY), None)


def held(state: CellState) -> Iterator[e.HoldRaised]:
    """Ask about a goal that failed, where it is in doubt; all others are over."""
    run = state.manual
    assert run is not None
    task = manual_task(state.cell, run.component, run.name, run.args)
    if state.phase(e.MANUAL_KEY) is Phase.FAILED and will_hold(state, e.MANUAL_KEY, task):
        yield raise_hold(state, e.MANUAL_KEY, task)


class Panel:
    """The panel that a goal was sent from: the goal runs only while it is heard."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._heard = ledger.steady
        """When; a goal that is adopted has its time from the start of the node."""

    def hear(self, command: Command) -> Answer | None:
        """Take a sign of life off the record; None: this is another command, or not allowed."""
        if not isinstance(command, Asked) or not command.request.is_sign:
            return None
        state, run = self._ledger.state, self._ledger.state.manual
        if state.unit_mode is not UnitMode.MANUAL:
            return None
        if not_allowed(command) is not None or not_from_there(state, command) is not None:
            return None
        if run is not None and (run.who, run.known) == _sender(command):
            self._heard = self._ledger.steady
        return Answer(accepted=True, message=_HEARD)

    @property
    def is_silent(self) -> bool:
        """Tell whether a goal runs whose panel is not there any more."""
        return self._is_awaited and has_come(self._heard + SILENT_S, self._ledger.steady)

    @property
    def _is_awaited(self) -> bool:
        """Tell whether a goal runs that has not been cancelled."""
        running = self._ledger.state.running.get(e.MANUAL_KEY)
        return running is not None and running.cancel_cause is None

    def land(self) -> None:
        """Start the goal that was asked for; cancel one whose panel is silent."""
        state, run = self._ledger.state, self._ledger.state.manual
        if run is not None and run.ended is None and e.MANUAL_KEY not in state.tasks:
            self._start()
        if self.is_silent:
            self._ledger.record(effects.cancelled(state, [e.MANUAL_KEY], PANEL_LOST))
        elif self._is_awaited:
            self._ledger.wake_at(self._heard + SILENT_S)

    def _start(self) -> None:
        ledger, run = self._ledger, self._ledger.state.manual
        assert run is not None
        self._heard = ledger.steady
        rivals = ledger.rivals(run.component)
        action = ledger.state.cell.components[run.component].action
        if rivals:
            failed = e.TaskFailed(
                **e.MANUAL_KEY._asdict(),
                attempt=1,
                reason=Reason.GOAL_REJECTED.value,
                message=Contest(tuple(rivals)).words(action),
            )
            ledger.record([failed])
            return
        started = e.TaskStarted(
            **e.MANUAL_KEY._asdict(),
            name=run.name,
            action=action,
            component=run.component,
            attempt=1,
            goal=ledger.new_goal_id(),
            args=dict(run.args),
            server=ledger.server(run.component),
            uptime=ledger.uptime,
        )
        ledger.record([started])


def _sender(asked: Asked) -> tuple[str, str]:
    return asked.sender.who, asked.sender.known.value


def goal_of(state: CellState) -> ManualGoal | None:
    """Return the goal of manual mode, or the last one, for the status."""
    run, task = state.manual, state.tasks.get(e.MANUAL_KEY)
    if run is None or task is None:
        return None
    word = task.reason.value if task.reason is not None else 'done'
    if task.phase is Phase.RUNNING:
        word = 'running' if task.cancel_cause is None else 'cancelling'
    return ManualGoal(
        **shared(run, ManualGoal),
        task=run.name,
        state=word,
        goal=task.goal or '',
        started=task.started or run.asked,
        message=task.message,
    )
