"""The SVG of a line: the same picture as its DOT text, without any other program."""

from __future__ import annotations

from collections import Counter
from functools import cache
from xml.etree import ElementTree as ET

import pytest
from fakes.dot_text import DotText
from fakes.dot_text import words as dot_words
from fakes.line import THREE, Line, with_section
from fakes.long_line import LONG, long_line

from bt_orchestrator.drawing.canvas import PADDING
from bt_orchestrator.drawing.line import draw_line
from bt_orchestrator.drawing.line_state import LineState, Mark, SectionMark, TaskMark
from bt_orchestrator.drawing.picture import Picture

SVG = '{http://www.w3.org/2000/svg}'
WAITS = TaskMark(Mark.WAITING, reason='for ' + 'a component with a long name ' * 4)
STATE = LineState(
    'Execute',
    ('WO-1 (test): Running',),
    belt_moves=True,
    tasks={'work10': WAITS, 'work11': TaskMark(Mark.HELD, '(hold 1)', 'timeout')},
    sections={9: SectionMark(slot='WO-1/1', is_rejected=True, works_on='WO-1/1')},
)


@cache
def picture(state: bool) -> Picture:
    line = long_line()
    return draw_line(line.script(LONG), line.cell, STATE if state else None)


class SvgText:
    """The parts of a picture, by name."""

    def __init__(self, text: str) -> None:
        self.root = ET.fromstring(text)
        self.parts = {part.get('id', ''): part for part in self.root.iter(f'{SVG}g')}

    def words(self, part: str) -> list[str]:
        return [(text.text or '').strip(' \xa0') for text in self.parts[part].iter(f'{SVG}text')]

    def title(self, part: str) -> str:
        return self.parts[part].findtext(f'{SVG}title') or ''


@pytest.mark.parametrize('state', [False, True])
def test_it_says_what_the_dot_text_says(state: bool) -> None:
    svg, dot = SvgText(picture(state).svg), DotText(picture(state).dot)
    for name in dot.nodes:
        if name not in ('node', 'edge', 'graph') and 'label' in dot.nodes[name]:
            assert svg.words(name) == dot.words(name), name
    for name, attributes in dot.clusters.items():
        assert svg.words(name) == dot_words(attributes['label']), name
    flags = {e['id']: e for e in dot.edges.values() if e.get('id', '').startswith('flag.')}
    assert len(flags) == len(long_line().script(LONG).dependencies)
    for name, edge in flags.items():
        assert svg.words(name) == dot_words(edge['label'])
        assert svg.title(name) == edge['edgetooltip']
    assert svg.title('task.work10') == dot.nodes['task.work10']['tooltip']


@pytest.mark.parametrize('state', [False, True])
def test_no_text_leaves_its_card(state: bool) -> None:
    svg, dot = SvgText(picture(state).svg), DotText(picture(state).dot)
    height = float(svg.root.get('viewBox', '').split()[3]) - 2 * PADDING
    cards = [name for name in dot.nodes if name.startswith('task.')]
    assert len(cards) > 30
    for name in cards:
        card = dot.card(name.removeprefix('task.'))
        for text in svg.parts[name].iter(f'{SVG}text'):
            x, y = float(text.get('x', '')), height - float(text.get('y', ''))
            size = float(text.get('font-size', ''))
            assert card.bottom <= y <= card.top - 0.7 * size, (name, text.text)
            assert card.left <= x <= card.right, (name, text.text)


def test_every_part_has_a_name_of_its_own_and_says_more() -> None:
    svg = SvgText(picture(True).svg)
    names = Counter(part.get('id') for part in svg.root.iter(f'{SVG}g'))
    assert set(names.values()) == {1}
    for name in names:
        if name and name.startswith(('task.', 'slot.', 'section.', 'flag.', 'belt')):
            is_arrow = '-' in name
            assert svg.title(name) or is_arrow, name


def test_every_part_lies_in_a_layer_and_in_no_other_part() -> None:
    # so a page can change one part, and leave the others as they are
    svg = SvgText(picture(True).svg)
    layers = svg.root.findall(f'{SVG}g')
    assert [layer.get('id') for layer in layers] == ['frames', 'lines', 'labels']
    parts = [part for layer in layers for part in layer.findall(f'{SVG}g')]
    assert len(parts) + len(layers) == len(list(svg.root.iter(f'{SVG}g')))
    assert all(part.get('id') for part in parts)


def test_a_screen_reader_is_told_what_it_is() -> None:
    svg = SvgText(picture(False).svg)
    assert svg.root.get('role') == 'img'
    assert svg.root.findtext(f'{SVG}title') == 'script test'


def test_what_xml_cannot_carry_breaks_no_file() -> None:
    line = Line()
    script = line.script(with_section(2, '- {id: work, @a2}'))
    said = TaskMark(Mark.HELD, '(hold 1)', 'aborted (\x1b[31m \x00 <&"> \ud800 \\N)')
    drawn = draw_line(script, line.cell, LineState('Held', (), False, {'work': said}))
    assert 'aborted (\ufffd[31m \ufffd <&"> \ufffd \\N)' in SvgText(drawn.svg).title('task.work')
    assert drawn.content('png').startswith(b'\x89PNG')
    assert drawn.content('dot')


def test_the_same_is_always_drawn_the_same() -> None:
    line = Line()
    assert len({draw_line(line.script(THREE), line.cell).svg for _ in range(2)}) == 1
