"""The SVG of a line: its text, names and tooltips."""

from __future__ import annotations

from collections import Counter
from functools import cache

import pytest
from fakes.line import THREE, Line, with_section
from fakes.line_picture import SVG, DrawnLine
from fakes.long_line import LONG, long_line

from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.view.drawing.picture import LinePicture

MARGIN = 2.0
"""Points between a letter and the frame around it."""
WAITS = TaskMark(Mark.WAITING, reason='for ' + 'a component with a long name ' * 4)
STATE = LineState(
    'Execute',
    ('WO-1 (test): Running',),
    belt_moves=True,
    tasks={'work10': WAITS, 'work11': TaskMark(Mark.HELD, '(hold 1)', 'timeout')},
    sections={9: SectionMark(slot='WO-1/1', is_rejected=True, works_on='WO-1/1')},
)


@cache
def picture(state: bool) -> LinePicture:
    line = long_line()
    return draw_line(line.script(LONG), line.cell, STATE if state else None)


@pytest.mark.parametrize('state', [False, True])
def test_text_stays_inside_margins_of_card(state: bool) -> None:
    drawn = DrawnLine(picture(state).svg)
    cards = [name for name in drawn.parts if name.startswith('task.') and '-' not in name]
    assert len(cards) > 30
    for name in cards:
        card = drawn.area(name)
        for text in drawn.parts[name].iter(f'{SVG}text'):
            x, y = float(text.get('x', '')), float(text.get('y', ''))
            size = float(text.get('font-size', ''))
            assert card.top + MARGIN <= y - 0.7 * size, (name, text.text)
            assert y <= card.bottom - MARGIN, (name, text.text)
            assert card.left + MARGIN <= x <= card.right - MARGIN, (name, text.text)


def test_every_part_has_unique_name_and_tooltip() -> None:
    svg = DrawnLine(picture(True).svg)
    names = Counter(part.get('id') for part in svg.root.iter(f'{SVG}g'))
    assert set(names.values()) == {1}
    for name in names:
        if name and name.startswith(('task.', 'slot.', 'section.', 'flag.', 'belt')):
            is_arrow = '-' in name
            assert svg.about(name) or is_arrow, name


def test_every_part_lies_directly_in_layer() -> None:
    # so a page can change one part, and leave the others as they are
    svg = DrawnLine(picture(True).svg)
    layers = svg.root.findall(f'{SVG}g')
    assert [layer.get('id') for layer in layers] == ['frames', 'lines', 'labels']
    parts = [part for layer in layers for part in layer.findall(f'{SVG}g')]
    assert len(parts) + len(layers) == len(list(svg.root.iter(f'{SVG}g')))
    assert all(part.get('id') for part in parts)


def test_a_screen_reader_is_told_what_it_is() -> None:
    svg = DrawnLine(picture(False).svg)
    assert svg.root.get('role') == 'img'
    assert svg.root.findtext(f'{SVG}title') == 'script test'


def test_what_xml_cannot_carry_breaks_no_file() -> None:
    line = Line()
    script = line.script(with_section(2, '- {id: work, @a2}'))
    mark = TaskMark(Mark.HELD, '(hold 1)', 'aborted (\x1b[31m \x00 <&"> \ud800 \\N)')
    drawn = draw_line(script, line.cell, LineState('Held', (), False, {'work': mark}))
    assert 'aborted (\ufffd[31m \ufffd <&"> \ufffd \\N)' in DrawnLine(drawn.svg).about('task.work')
    assert drawn.content('png').startswith(b'\x89PNG')


def test_the_same_is_always_drawn_the_same() -> None:
    line = Line()
    assert len({draw_line(line.script(THREE), line.cell).svg for _ in range(2)}) == 1
