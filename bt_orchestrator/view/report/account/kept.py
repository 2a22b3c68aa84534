"""The text form of books: slots, the state of a course, scripts."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TypeVar

from bt_orchestrator.model.books import KeptScript, KeptSlot, KeptState
from bt_orchestrator.model.codec import from_plain, json_of, text_of
from bt_orchestrator.model.script import Script
from bt_orchestrator.view.report.account.course import Course
from bt_orchestrator.view.report.account.slot import Slot
from bt_orchestrator.view.report.account.steady_time import SteadyTime

_T = TypeVar('_T')

VERSION = 2
"""Of what the texts mean. Books of another version are not read: their time is not recorded."""

WITHOUT_STEPS = 1
"""The version before, which is read: a clock that was set back made it leave out time."""


def keep_slot(slot: Slot, made_of: int) -> KeptSlot:
    """Return a slot as text.

    :param made_of: seq of the last event that has a say in it
    """
    return KeptSlot(slot.begin_us, slot.until_us, made_of, VERSION, json_of(slot))


def read_slot(kept: KeptSlot) -> Slot | None:
    """Return what a text says; None: it is of another version."""
    return _read(lambda: from_plain(Slot, json.loads(kept.text)), kept.version)


def keep_state(
    course: Course, steady: SteadyTime, seq: int, made_of: int, *, stays: bool
) -> KeptState:
    """Return the state of a course after an event as text.

    :param made_of: seq of the last event that has a say in it
    """
    assert course.now is not None
    plain = {**course.plain(), 'steady': steady.plain(seq)}
    return KeptState(seq, course.now, made_of, stays, VERSION, json_of(plain))


def read_state(kept: KeptState) -> Course | None:
    """Return a course that goes on from there; None: the text is of another version."""
    return _read(lambda: Course.from_plain(json.loads(kept.text)), kept.version)


def read_steady(kept: KeptState) -> SteadyTime | None:
    """Return what a state knows of the steps of the clock; None: it is of another version."""
    if kept.version == WITHOUT_STEPS:
        return SteadyTime(kept.seq)

    def read() -> SteadyTime:
        return SteadyTime.from_plain(json.loads(kept.text)['steady'], kept.seq)

    return _read(read, kept.version)


def keep_script(digest: str, script: Script) -> KeptScript:
    """Return a script as text."""
    return KeptScript(digest, text_of(script))


def read_script(kept: KeptScript) -> Script:
    """Return what a text says."""
    return from_plain(Script, json.loads(kept.text))


def _read(read: Callable[[], _T], version: int) -> _T | None:
    if version not in (VERSION, WITHOUT_STEPS):
        return None
    try:
        return read()
    except (AssertionError, AttributeError, KeyError, TypeError, ValueError):
        return None
