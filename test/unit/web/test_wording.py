"""Drawings in the languages of the page: complete, and the same line."""

from __future__ import annotations

import asyncio
import re

import pytest
from fakes.long_line import LONG, long_line
from fakes.page_parts import status_of

from bt_orchestrator.drawing.line_state import Mark
from bt_orchestrator.drawing.wording import ENGLISH
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.web.scripts.drawing import Drawings
from bt_orchestrator.web.scripts.wording import wordings

GERMAN = wordings()['de']


def test_english_is_that_of_the_code() -> None:
    assert wordings()['en'] is ENGLISH


def test_a_drawing_has_the_same_parts_in_each_language() -> None:
    line = long_line()
    run = line.begin(LONG)
    run.go(until=2.5)
    script, drawings = run.job().job.script, Drawings()

    async def drawn(language: str) -> str:
        found = await drawings.drawn(digest(script), script, line.cell, status_of(run), language)
        return found.svg.decode()

    english, german = (asyncio.run(drawn(language)) for language in ('en', 'de'))
    assert english == asyncio.run(drawn('en')), 'another language was kept in its place'
    assert 'Legende' in german
    parts = r' id="([^"]+)"'
    assert re.findall(parts, english) == re.findall(parts, german)


@pytest.mark.parametrize('kind', WaitKind)
def test_each_wait_is_said(kind: WaitKind) -> None:
    said = GERMAN.wait(Wait('waiting', kind, 'a', (1, 2, 3, 4, 5), 'weld'))
    assert '{' not in said
    assert 'waiting' not in said


def test_a_wait_says_the_state_of_the_cell_and_how_many_sections_more() -> None:
    complete = Wait('the cell is Complete', WaitKind.CELL_STATE, 'Complete')
    assert GERMAN.wait(complete) == 'die Zelle ist: Alle Aufträge fertig'
    assert GERMAN.wait(Wait('x', WaitKind.CELL_STATE, 'item')) == 'die Linie fährt leer und stoppt'
    many = Wait('x', WaitKind.TURN, sections=(1, 2, 3, 4, 5))
    assert GERMAN.wait(many) == 'wartet auf Station 1, Station 2, Station 3, 2 weitere'


def test_states_marks_and_failures_are_said_and_what_a_server_said_stays() -> None:
    for state in PackmlState:
        assert GERMAN.state(state) != state.value
    for mark in Mark:
        assert GERMAN.mark(mark) != mark.word
    for reason in Reason:
        assert GERMAN.failure(reason.value, '') != reason.value
    assert GERMAN.failure('timeout', 'Too late') == 'hat zu lange gedauert (Too late)'
    assert GERMAN.passed('timeout (Too late)') == 'hat zu lange gedauert (Too late)'
    assert GERMAN.passed('rejected item') == 'das Teil ist Ausschuss'
    assert GERMAN.passed('as somebody said') == 'as somebody said'
