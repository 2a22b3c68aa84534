"""Drawings of scripts as lines: what a reviewer finds in them, and where."""

from __future__ import annotations

import sys
from functools import cache
from itertools import combinations, pairwise

import pytest
from fakes.action_types import FakeActionTypes
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, Line, with_section
from fakes.line_picture import SVG, DrawnLine
from fakes.long_line import LONG, long_line
from fakes.plan_runs import product_cell, product_scripts
from fakes.profiles import examples
from fakes.shipped import REFERENCE_CELL, ROOT, TREES
from hypothesis import given

from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.view.drawing.label import wrapped
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.line_state import LineState
from bt_orchestrator.view.drawing.picture import CannotDraw, LinePicture

TYPES = FakeActionTypes()
SHIPPED = sorted(path.stem for path in TREES.glob('*.yaml'))


def shipped(name: str) -> LinePicture:
    cell = read_cell(REFERENCE_CELL, TYPES)
    return draw_line(read_script(TREES / f'{name}.yaml', cell, TYPES), cell)


def drawn(text: str) -> DrawnLine:
    line = Line()
    return DrawnLine(draw_line(line.script(text), line.cell).svg)


@cache
def long() -> DrawnLine:
    line = long_line()
    return DrawnLine(draw_line(line.script(LONG), line.cell).svg)


# --- shipped pictures -----------------------------------------------------------------------


@pytest.mark.parametrize('name', SHIPPED)
def test_drawing_of_shipped_script_is_current(name: str) -> None:
    beside = TREES / f'{name}.svg'
    known = beside.read_text() if beside.exists() else ''
    assert known == shipped(name).svg, 'run scripts/render, and look at the pictures'


def test_there_are_shipped_scripts() -> None:
    assert len(SHIPPED) >= 2


def test_drawing_is_reproducible_and_independent_of_machine() -> None:
    picture = shipped('inspect_and_assemble')
    assert picture == shipped('inspect_and_assemble')
    assert str(ROOT) not in picture.svg


# --- what is on a card ----------------------------------------------------------------------


def test_a_plain_task_is_id_constant_and_action() -> None:
    assert drawn(THREE).words('task.work') == ['work', 'TASK_A', '/a2/do']


@pytest.mark.parametrize(
    ('option', 'words'),
    [
        ('retries: 1', 'retry once'),
        ('retries: 2, retry_delay: 1.5', 'retry 2 times, after 1.5 s'),
        ('on_failure: reject', 'if it fails: reject the item'),
        ('continue_if_fail: true', 'if it fails: continue'),
        ('on_failure: abort_job', 'if it fails: abort the job'),
        ('timeout: 7.5', 'at most 7.5 s'),
        ('timeout: none', 'no time limit'),
        ('runs_for: rejected', 'for rejected items only'),
        ('runs_for: all', 'for good and rejected items'),
        ('repeatable: true', 'repeatable'),
        ('unless: "${params.dry}"', 'unless ${params.dry}'),
        ('fails_unless: "${results.work.item_present}"', 'fails unless'),
        ('args: {special_argument_1: "${params.lot}!"}', 'special_argument_1: ${params.lot}!'),
        ('requires_conveyor: false', 'while the belt moves'),
    ],
)
def test_an_option_is_on_the_card(option: str, words: str) -> None:
    params = 'params: {lot: {type: str}, dry: {type: bool, default: false}}'
    use = '- {id: more, @b2, args: {special_argument_1: "${params.lot} ${params.dry}"}}'
    text = with_section(2, f'- {{id: work, @a2, {option}}}\n{use}')
    text = text.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    assert words in drawn(f'{params}\n{text}').words('task.work')


def test_default_time_limit_of_component_is_omitted() -> None:
    assert not any('at most' in word for word in drawn(THREE).words('task.work'))


def test_long_argument_is_cut_except_in_tooltip() -> None:
    value = 'word ' * 60 + 'end'
    text = with_section(2, f'- {{id: work, @a2, args: {{special_argument_1: "{value}"}}}}')
    picture = drawn(text)
    shown = picture.words('task.work')
    assert len(shown) == 6
    assert shown[-1].endswith('\u2026')
    assert f'argument special_argument_1: {value}' in picture.about('task.work')


def test_xml_characters_appear_as_plain_text() -> None:
    value = '<B>&amp; \\\\N \\"x\\"'
    text = with_section(2, f'- {{id: work, @a2, args: {{special_argument_1: "{value}"}}}}')
    picture = drawn(text)
    assert 'special_argument_1: <B>&amp; \\N' in picture.words('task.work')
    assert '<B>&amp; \\N "x"' in picture.about('task.work')


def test_items_come_and_go() -> None:
    picture = drawn(THREE)
    assert '+1 item' in picture.words('task.place')
    assert '\u22121 item' in picture.words('task.pack')


@pytest.mark.parametrize(
    ('tasks', 'seen'),
    [
        (
            '- {id: early, @b2, requires_conveyor: false}\n- {id: work, @a2}',
            'while the belt moves',
        ),
        (
            '- {id: work, @a2}\n- {id: early, @b2, requires_conveyor: false}\n- {id: x, @a2}',
            'does not need the belt',
        ),
        (
            '- parallel: [{id: early, @b2, requires_conveyor: false}, {id: work, @a2}]',
            'does not need the belt',
        ),
    ],
)
def test_how_a_task_relates_to_the_belt(tasks: str, seen: str) -> None:
    picture = drawn(with_section(2, tasks))
    assert seen in picture.words('task.early')
    assert picture.look('task.early').get('stroke-dasharray')
    assert not picture.look('task.work').get('stroke-dasharray')


# --- what couples the sections --------------------------------------------------------------


def test_a_flag_is_an_edge_with_its_counts() -> None:
    assert long().words('flag.far') == ['flag far', 'capacity 12, initial 2']
    assert 'work15 starts while it is above 0' in long().about('flag.far')
    assert '\u25b2 sets flag far' in long().words('task.work4')
    assert '\u25bc takes flag far' in long().words('task.work15')


def test_zone_is_named_on_each_of_its_tasks() -> None:
    for task in ('work10', 'work11', 'work17'):
        assert '\u25a0 zone crane' in long().words(f'task.{task}')


def test_repeat_shows_frame_return_path_and_outcome() -> None:
    judged = 'fails_unless: "${results.look.item_present}", on_failure: reject'
    repeat = f'- repeat: [{{id: glue, @b2}}, {{id: look, @a2, {judged}}}]\n  times: 2'
    picture = drawn(
        with_section(2, repeat).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    )
    assert picture.words('repeat.glue') == ['\u21bb up to 2 more rounds']
    assert picture.words('repeat.glue.after') == ['after the last round: reject the item']
    assert picture.points('repeat.glue.back')
    assert '\u21bb' in picture.words('legend')
    assert '\u21bb' not in drawn(THREE).words('legend')


def test_each_verdict_states_action_after_last_round() -> None:
    judged = 'fails_unless: "${results.NAME.item_present}"'
    verdict, other = (judged.replace('NAME', name) for name in ('glue', 'look'))
    tasks = f'[{{id: glue, @b2, {verdict}, on_failure: continue}}, {{id: look, @a2, {other}}}]'
    picture = drawn(with_section(2, f'- repeat: {tasks}'))
    shown_text = ' '.join(picture.words('repeat.glue.after')).replace('   ', ' ')
    assert 'after the last round of glue: continue' in shown_text
    assert 'after the last round of look: hold, an operator decides' in shown_text


def test_initialization_is_a_group_with_its_order() -> None:
    picture = long()
    assert picture.words('initialization') == ['Initialization, per order']
    assert 'once, until the cell stops' in picture.words('task.home')
    assert 'task.home-task.prepare_2' in picture.parts
    assert picture.card('home').bottom < picture.card('prepare_2').top
    assert picture.area('initialization').holds(picture.card('prepare_4'))


def test_the_belts_own_move() -> None:
    assert long().words('task.index') == ['index', 'MOVE_ONE_INDEX', '/belt/do', 'retry once']


def test_the_belt_is_released_where_the_turn_ends() -> None:
    picture = long()
    release = picture.area('section.9.release')
    assert picture.card('grip').bottom < release.top < release.bottom < picture.card('store').top
    releases = [name for name in picture.parts if name.endswith('.release') and '-' not in name]
    assert releases == ['section.9.release']


def test_title_and_parameters() -> None:
    assert long().words('title') == [
        'test',
        'for cell test_line, 20 sections',
        'parameter lot: str, default A7',
        'parameter force: float, required',
        'quantity: default 12',
    ]


def test_legend_explains_only_drawn_marks() -> None:
    everything, little = long().words('legend'), drawn(THREE).words('legend')
    for mark in ('dashed frame', '- - \u25b6 flag', '\u25a0 zone', 'belt released'):
        assert mark in everything
        assert mark not in little


def test_a_section_without_tasks_is_there() -> None:
    assert long().words('section.8.idle') == ['no task: items pass']
    assert long().words('section.8') == ['Section 8']


# --- where it stands ------------------------------------------------------------------------


def test_sections_stand_in_the_order_of_the_belt() -> None:
    areas = [long().area(f'section.{number}') for number in range(1, 21)]
    for current, following in pairwise(areas):
        same_row = current.top == following.top
        assert current.right < following.left if same_row else current.bottom < following.top
    assert len({area.top for area in areas}) > 1
    assert all(f'belt.{n}' in long().parts for n in range(1, 20))


def test_six_sections_with_two_groups_fit_one_row() -> None:
    line = Line(6)
    groups = (f'{n}: [{{parallel: [{{id: l{n}, @a{n}}}, {{id: r{n}, @b{n}}}]}}]' for n in (2, 4))
    ends = ('1: [{id: place, @a1, qty_change: 1}]', '6: [{id: pack, @a6, qty_change: -1}]')
    text = '\n  '.join(('sections:', *ends, *groups))
    picture = DrawnLine(draw_line(line.script(text), line.cell).svg)
    assert len({picture.area(f'section.{number}').top for number in range(1, 7)}) == 1


def test_titles_of_source_and_sink() -> None:
    assert long().words('section.1') == ['Section 1 \u00b7 source']
    assert long().words('section.20') == ['Section 20 \u00b7 sink']


def test_the_members_of_a_group_stand_in_it() -> None:
    group = long().area('section.5.group.1')
    for task in ('turn5', 'weld5', 'watch5'):
        assert group.holds(long().card(task))
    assert long().area('section.5').holds(group)


def check_places(picture: DrawnLine, script: Script) -> None:
    """Nothing covers anything, and every task stands in its section."""
    cards = {task: picture.card(task) for task in script.tasks}
    for first_card, other in combinations(cards.values(), 2):
        assert not first_card.meets(other)
    for task, card in cards.items():
        section = script.section_of(task)
        frame = f'section.{section}' if section else 'initialization'
        assert picture.area(frame).holds(card), task


def test_nothing_covers_anything_on_a_long_line() -> None:
    check_places(long(), long_line().script(LONG))


@examples(30, 300)
@given(lines())
def test_nothing_covers_anything_on_drawn_lines(plan: Plan) -> None:
    cell = product_cell(plan)
    for script in product_scripts(plan, cell).values():
        check_places(DrawnLine(draw_line(script, cell).svg), script)


@pytest.mark.parametrize(
    ('upstream', 'downstream'), [('work', 'pack'), ('place', 'pack'), ('pack', 'place')]
)
def test_a_flag_begins_and_ends_at_its_tasks(upstream: str, downstream: str) -> None:
    flag = f'{{flag: f, upstream: {upstream}, downstream: {downstream}, initial: 1}}'
    picture = drawn(f'{THREE}lateral_dependencies: [{flag}]')
    start, *_, tip = picture.points('flag.f')
    there, here = picture.card(downstream), picture.card(upstream)
    assert tip == (there.left, (there.bottom + there.top) / 2)
    assert start == (here.right, (here.bottom + here.top) / 2)


def test_flag_labels_do_not_cover_each_other() -> None:
    text = with_section(2, '- parallel: [{id: left, @a2}, {id: right, @b2}]')
    flags = [('f', 'left', 'pack'), ('g', 'right', 'pack'), ('h', 'right', 'place')]
    listed = [f'{{flag: {f}, upstream: {u}, downstream: {d}, initial: 1}}' for f, u, d in flags]
    picture = drawn(f'{text}lateral_dependencies: [{", ".join(listed)}]')
    labels = sorted(
        float(next(part.iter(f'{SVG}text')).get('y', ''))
        for name, part in picture.parts.items()
        if name.startswith('flag.')
    )
    assert len(labels) == 3
    assert min(above - below for below, above in pairwise(labels)) >= 24


# --- files ----------------------------------------------------------------------------------


def test_a_picture_without_cairosvg_is_svg(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, 'cairosvg', None)
    line = Line()
    picture = draw_line(line.script(THREE), line.cell)
    assert picture.content('svg').startswith(b'<?xml')
    with pytest.raises(CannotDraw, match=r'^PNG and PDF need CairoSVG, .* a \.svg file$'):
        picture.content('png')


@pytest.mark.parametrize(('kind', 'begin'), [('png', b'\x89PNG'), ('pdf', b'%PDF')])
def test_the_other_files_are_made_of_the_svg(kind: str, begin: bytes) -> None:
    line = Line()
    assert draw_line(line.script(THREE), line.cell).content(kind).startswith(begin)


# --- the pace -------------------------------------------------------------------------------

LIMITS = '\u25c6 limits the pace'


def test_what_limits_the_pace_is_told_and_marked() -> None:
    line = Line(seconds={'a2': 7.0})
    picture = DrawnLine(draw_line(line.script(THREE), line.cell).svg)
    assert picture.words('title')[-1] == 'pace: 9.0 s per item, limited by work + index move'
    assert [LIMITS in picture.words(part) for part in ('task.work', 'task.index')] == [True, True]
    assert LIMITS not in picture.words('task.place')
    assert '\u25c6 limits' in picture.words('legend')
    assert 'nominal time: 7 s' in picture.about('task.work')


def test_running_line_does_not_mark_pace_limit() -> None:
    line = Line(seconds={'a2': 7.0})
    state = LineState('Execute', (), False, {})
    picture = DrawnLine(draw_line(line.script(THREE), line.cell, state).svg)
    assert LIMITS not in picture.words('task.work')


@pytest.mark.parametrize(
    ('text', 'lines'),
    [
        ('loader_place_at_conveyor', ['loader_place_at_', '  conveyor']),
        ('packer_pick_and_pack', ['packer_pick_and_', '  pack']),
        ('a_bcdefghijklmnopqrstuvwxyz', ['a_bcdefghijklmnop', '  qrstuvwxyz']),
        ('seventeen_letters', ['seventeen_letters']),
        ('two words_that_are_long', ['two', '  words_that_are_', '  long']),
        ('', ['']),
    ],
)
def test_a_long_name_is_broken_between_its_words(text: str, lines: list[str]) -> None:
    assert wrapped(text, 17) == lines
