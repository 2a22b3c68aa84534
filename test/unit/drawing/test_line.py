"""Drawings of scripts as lines: what a reviewer finds in them, and where."""

from __future__ import annotations

from functools import cache
from itertools import combinations, pairwise

import pytest
from fakes.action_types import FakeActionTypes
from fakes.dot_text import DotText, words
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, Line, with_section
from fakes.long_line import LONG, long_line
from fakes.plan_runs import product_cell, product_scripts
from fakes.profiles import examples
from fakes.shipped import REFERENCE_CELL, ROOT, TREES
from hypothesis import given

from bt_orchestrator.drawing.label import wrapped
from bt_orchestrator.drawing.line import draw_line
from bt_orchestrator.drawing.line_state import LineState
from bt_orchestrator.drawing.picture import DOT, SVG, CannotDraw, Picture
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script

TYPES = FakeActionTypes()
SHIPPED = sorted(path.stem for path in TREES.glob('*.yaml'))


def shipped(name: str) -> Picture:
    cell = read_cell(REFERENCE_CELL, TYPES)
    return draw_line(read_script(TREES / f'{name}.yaml', cell, TYPES), cell)


def drawn(text: str) -> DotText:
    line = Line()
    return DotText(draw_line(line.script(text), line.cell).dot)


@cache
def long() -> DotText:
    line = long_line()
    return DotText(draw_line(line.script(LONG), line.cell).dot)


# --- shipped pictures -----------------------------------------------------------------------


@pytest.mark.parametrize('kind', [DOT, SVG])
@pytest.mark.parametrize('name', SHIPPED)
def test_the_drawing_beside_a_shipped_script_is_up_to_date(name: str, kind: str) -> None:
    beside = TREES / f'{name}.{kind}'
    known = beside.read_bytes() if beside.exists() else b''
    assert known == shipped(name).content(kind), 'run scripts/render, and look at the pictures'


def test_there_are_shipped_scripts() -> None:
    assert len(SHIPPED) >= 2


def test_equal_scripts_are_drawn_equally_and_without_a_trace_of_the_machine() -> None:
    picture = shipped('inspect_and_assemble')
    assert picture == shipped('inspect_and_assemble')
    assert str(ROOT) not in picture.dot + picture.svg


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


def test_what_a_time_limit_is_compared_with_is_the_components() -> None:
    assert not any('at most' in word for word in drawn(THREE).words('task.work'))


def test_a_long_argument_is_cut_and_whole_in_the_tooltip() -> None:
    value = 'word ' * 60 + 'end'
    dot = drawn(with_section(2, f'- {{id: work, @a2, args: {{special_argument_1: "{value}"}}}}'))
    shown = dot.words('task.work')
    assert len(shown) == 6
    assert shown[-1].endswith('\u2026')
    assert f'argument special_argument_1: {value}' in dot.nodes['task.work']['tooltip']


def test_text_that_means_something_to_graphviz_is_only_text() -> None:
    value = '<B>&amp; \\\\N \\"x\\"'
    text = with_section(2, f'- {{id: work, @a2, args: {{special_argument_1: "{value}"}}}}')
    dot = drawn(text)
    label = dot.nodes['task.work']['label']
    assert 'special_argument_1: &lt;B&gt;&amp;amp; \\N' in label
    assert '<B>&amp; \\\\N "x"' in dot.nodes['task.work']['tooltip']


def test_items_come_and_go() -> None:
    dot = drawn(THREE)
    assert '+1 item' in dot.words('task.place')
    assert '\u22121 item' in dot.words('task.pack')


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
    dot = drawn(with_section(2, tasks))
    assert seen in dot.words('task.early')
    assert 'STYLE="dashed"' in dot.nodes['task.early']['label']
    assert 'STYLE="dashed"' not in dot.nodes['task.work']['label']


# --- what couples the sections --------------------------------------------------------------


def test_a_flag_is_an_edge_with_its_counts() -> None:
    edge = long().edges['task.work4 -> task.work15']
    assert words(edge['label']) == ['flag far', 'capacity 12, initial 2']
    assert 'work15 starts while it is above 0' in edge['edgetooltip']
    assert '\u25b2 sets flag far' in long().words('task.work4')
    assert '\u25bc takes flag far' in long().words('task.work15')


def test_a_zone_is_named_on_each_of_its_tasks() -> None:
    for task in ('work10', 'work11', 'work17'):
        assert '\u25a0 zone crane' in long().words(f'task.{task}')


def test_a_repeat_is_a_frame_with_a_way_back_and_what_follows() -> None:
    judged = 'fails_unless: "${results.look.item_present}", on_failure: reject'
    repeat = f'- repeat: [{{id: glue, @b2}}, {{id: look, @a2, {judged}}}]\n  times: 2'
    picture = drawn(
        with_section(2, repeat).replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    )
    assert words(picture.clusters['repeat.glue']['label']) == ['\u21bb up to 2 more rounds']
    assert picture.words('repeat.glue.after') == ['after the last round: reject the item']
    assert picture.edges['task.look -> task.glue']['id'] == 'repeat.glue.back'
    assert '\u21bb' in picture.words('legend')
    assert '\u21bb' not in drawn(THREE).words('legend')


def test_verdicts_of_one_repeat_say_each_what_follows_the_last_round() -> None:
    judged = 'fails_unless: "${results.NAME.item_present}"'
    one, other = (judged.replace('NAME', name) for name in ('glue', 'look'))
    tasks = f'[{{id: glue, @b2, {one}, on_failure: continue}}, {{id: look, @a2, {other}}}]'
    picture = drawn(with_section(2, f'- repeat: {tasks}'))
    said = ' '.join(picture.words('repeat.glue.after')).replace('   ', ' ')
    assert 'after the last round of glue: continue' in said
    assert 'after the last round of look: hold, an operator decides' in said


def test_initialization_is_a_group_with_its_order() -> None:
    dot = long()
    assert words(dot.clusters['initialization']['label']) == ['Initialization, per order']
    assert 'once, until the cell stops' in dot.words('task.home')
    assert 'task.home -> task.prepare_2' in dot.edges
    assert dot.card('home').bottom > dot.card('prepare_2').top
    assert dot.area('initialization').holds(dot.card('prepare_4'))


def test_the_belts_own_move() -> None:
    assert long().words('task.index') == ['index', 'MOVE_ONE_INDEX', '/belt/do', 'retry once']


def test_the_belt_is_released_where_the_turn_ends() -> None:
    dot = long()
    release = dot.place('section.9.release')[1]
    assert dot.card('grip').bottom > release > dot.card('store').top
    assert [name for name in dot.nodes if name.endswith('.release')] == ['section.9.release']


def test_title_and_parameters() -> None:
    assert long().words('title') == [
        'test',
        'for cell test_line, 20 sections',
        'parameter lot: str, default A7',
        'parameter force: float, required',
        'quantity: default 12',
    ]


def test_the_legend_explains_what_is_there_and_nothing_else() -> None:
    everything, little = long().words('legend'), drawn(THREE).words('legend')
    for mark in ('dashed frame', '- - \u25b6 flag', '\u25a0 zone', 'belt released'):
        assert mark in everything
        assert mark not in little


def test_a_section_without_tasks_is_there() -> None:
    assert long().words('section.8.idle') == ['no task: items pass']
    assert words(long().clusters['section.8']['label']) == ['Section 8']


# --- where it stands ------------------------------------------------------------------------


def test_sections_stand_in_the_order_of_the_belt() -> None:
    areas = [long().area(f'section.{number}') for number in range(1, 21)]
    for one, following in pairwise(areas):
        same_row = one.top == following.top
        assert one.right < following.left if same_row else one.bottom > following.top
    assert len({area.top for area in areas}) > 1
    assert [f'slot.{n} -> slot.{n + 1}' in long().edges for n in range(1, 20)] == [True] * 19


def test_six_sections_with_two_groups_stand_in_one_row() -> None:
    line = Line(6)
    groups = (f'{n}: [{{parallel: [{{id: l{n}, @a{n}}}, {{id: r{n}, @b{n}}}]}}]' for n in (2, 4))
    ends = ('1: [{id: place, @a1, qty_change: 1}]', '6: [{id: pack, @a6, qty_change: -1}]')
    text = '\n  '.join(('sections:', *ends, *groups))
    dot = DotText(draw_line(line.script(text), line.cell).dot)
    assert len({dot.area(f'section.{number}').top for number in range(1, 7)}) == 1


def test_titles_of_source_and_sink() -> None:
    assert words(long().clusters['section.1']['label']) == ['Section 1 \u00b7 source']
    assert words(long().clusters['section.20']['label']) == ['Section 20 \u00b7 sink']


def test_the_members_of_a_group_stand_in_it() -> None:
    group = long().area('section.5.group.1')
    for task in ('turn5', 'weld5', 'watch5'):
        assert group.holds(long().card(task))
    assert long().area('section.5').holds(group)


def check_places(dot: DotText, script: Script) -> None:
    """Nothing covers anything, and every task stands in its section."""
    cards = {task: dot.card(task) for task in script.tasks}
    for one, other in combinations(cards.values(), 2):
        assert not one.meets(other)
    for task, card in cards.items():
        section = script.section_of(task)
        frame = f'section.{section}' if section else 'initialization'
        assert dot.area(frame).holds(card), task


def test_nothing_covers_anything_on_a_long_line() -> None:
    check_places(long(), long_line().script(LONG))


@examples(30, 300)
@given(lines())
def test_nothing_covers_anything_on_drawn_lines(plan: Plan) -> None:
    cell = product_cell(plan)
    for script in product_scripts(plan, cell).values():
        check_places(DotText(draw_line(script, cell).dot), script)


@pytest.mark.parametrize(
    ('upstream', 'downstream'), [('work', 'pack'), ('place', 'pack'), ('pack', 'place')]
)
def test_a_flag_begins_and_ends_at_its_tasks(upstream: str, downstream: str) -> None:
    flag = f'{{flag: f, upstream: {upstream}, downstream: {downstream}, initial: 1}}'
    dot = drawn(f'{THREE}lateral_dependencies: [{flag}]')
    way = dot.edges[f'task.{upstream} -> task.{downstream}']['pos'].split()
    tip = tuple(float(number) for number in way[0].removeprefix('e,').split(','))
    start = tuple(float(number) for number in way[1].split(','))
    there, here = dot.card(downstream), dot.card(upstream)
    assert tip == (there.left, (there.bottom + there.top) / 2)
    assert start == (here.right, (here.bottom + here.top) / 2)
    assert len(way) % 3 == 2  # the tip, and 3n + 1 points


def test_flags_of_neighbours_and_of_one_task_do_not_cover_each_other() -> None:
    text = with_section(2, '- parallel: [{id: left, @a2}, {id: right, @b2}]')
    flags = [('f', 'left', 'pack'), ('g', 'right', 'pack'), ('h', 'right', 'place')]
    listed = [f'{{flag: {f}, upstream: {u}, downstream: {d}, initial: 1}}' for f, u, d in flags]
    dot = drawn(f'{text}lateral_dependencies: [{", ".join(listed)}]')
    labels = sorted(float(edge['lp'].split(',')[1]) for edge in dot.edges.values() if 'lp' in edge)
    assert len(labels) == 3
    assert min(above - below for below, above in pairwise(labels)) >= 24


# --- files ----------------------------------------------------------------------------------


def test_only_pictures_that_graphviz_makes_need_dot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('PATH', '/nowhere')
    line = Line()
    picture = draw_line(line.script(THREE), line.cell)
    assert picture.content(SVG).startswith(b'<?xml')
    assert picture.content(DOT).startswith(b'// drawn with dot')
    with pytest.raises(
        CannotDraw, match=r'^the program `dot` .* missing; .* a \.svg or \.dot file$'
    ):
        picture.content('png')


@pytest.mark.parametrize(('kind', 'begin'), [('png', b'\x89PNG'), ('pdf', b'%PDF')])
def test_graphviz_makes_the_other_files(kind: str, begin: bytes) -> None:
    line = Line()
    assert draw_line(line.script(THREE), line.cell).content(kind).startswith(begin)


# --- the pace -------------------------------------------------------------------------------

LIMITS = '\u25c6 limits the pace'


def test_what_limits_the_pace_is_told_and_marked() -> None:
    line = Line(seconds={'a2': 7.0})
    dot = DotText(draw_line(line.script(THREE), line.cell).dot)
    assert dot.words('title')[-1] == 'an item every 9.0 s: work, the belt moves'
    assert [LIMITS in dot.words(one) for one in ('task.work', 'task.index')] == [True, True]
    assert LIMITS not in dot.words('task.place')
    assert '\u25c6 limits' in dot.words('legend')
    assert 'nominal time: 7 s' in dot.nodes['task.work']['tooltip']


def test_a_line_at_work_shows_how_it_stands_instead() -> None:
    line = Line(seconds={'a2': 7.0})
    state = LineState('Execute', (), False, {})
    dot = DotText(draw_line(line.script(THREE), line.cell, state).dot)
    assert LIMITS not in dot.words('task.work')


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
