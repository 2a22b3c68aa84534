"""Drawings of a line at work: what is on them at each point of a real (virtual) run."""

from __future__ import annotations

from typing import Any

import pytest
from fakes import statuses
from fakes.line import Line
from fakes.line_picture import DrawnLine

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.state import End, Hold, PassedTask
from bt_orchestrator.model.status import (
    BeltStatus,
    CellStatus,
    FlagStatus,
    JobStatus,
    SectionStatus,
)
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.line_state import Mark
from bt_orchestrator.view.drawing.status_marks import NotThisLine, line_state

SCRIPT = """
initialization: [{id: prepare, @a1.PREPARE}]
sections:
  1: [{id: feed, @a1, qty_change: 1}]
  2:
    - {id: look, @a2}
    - parallel: [[{id: turn, @a2}, {id: weld, @b2}], {id: watch, @lamp}]
  3: [{id: pack, @a3, qty_change: -1}]
lateral_dependencies: [{flag: seen, upstream: look, downstream: pack}]
"""


def job(id: str = 'WO-1', script: str = 'test', **about: Any) -> JobStatus:  # noqa: A002 - as in the status
    return changed(statuses.job(id, quantity=4, **about), script=script)


def hold(**about: Any) -> Hold:
    nowhere = dict.fromkeys(('section', 'item', 'task'))
    return statuses.hold(**{**nowhere, 'attempt': 0, 'reason': 'timeout', **about})


def status(*sections: SectionStatus, **about: Any) -> CellStatus:
    known = {section.number: section for section in sections}
    usual = {
        'cell': 'test_line',
        'seq': 17,
        'belt': BeltStatus(waits=(statuses.wait('waiting for section 2'),)),
        'sections': [known.get(n, statuses.section(n)) for n in (1, 2, 3)],
        'jobs': [job()],
        'flags': [FlagStatus('seen', 1, 1)],
    }
    return statuses.status(**{**usual, **about})


def drawn(state: CellStatus, text: str = SCRIPT) -> DrawnLine:
    line = Line()
    script = line.script(text)
    return DrawnLine(draw_line(script, line.cell, line_state(state, script, line.cell)).svg)


MOVING = BeltStatus(moving=True, running=(statuses.task('index'),))


def section_2(**about: Any) -> SectionStatus:
    """Return a section at work on an item, which may be rejected, and so on."""
    facts = {key: about.pop(key) for key in ('passed', 'failed') if key in about}
    return changed(statuses.section(2, 'WO-1/1', **about), **facts)


# --- tasks ------------------------------------------------------------------------------------


def marks(picture: DrawnLine) -> dict[str, str]:
    """Return the first line of every card."""
    return {
        name.removeprefix('task.'): picture.words(name)[0]
        for name in picture.parts
        if name.startswith('task.') and '-' not in name
    }


LOOKED = PassedTask('look', End.DONE)


def test_every_task_says_how_it_stands() -> None:
    turns = statuses.task('turn', attempt=2)
    at_work = section_2(passed=(LOOKED,), running=[turns], waiting=['for lamp'])
    assert marks(drawn(status(at_work))) == {
        'prepare': '\u2713 done',
        'index': '\u2026 waits',
        'feed': 'not begun',
        'look': '\u2713 done',
        'turn': '\u25b6 running (attempt 2)',
        'weld': 'not begun',
        'watch': '\u2026 waits',
        'pack': 'not begun',
    }


def test_what_failed_is_told_apart() -> None:
    look = PassedTask('look', End.CONTINUED, 'aborted')
    failed = section_2(passed=(look,), failed=('look', 'turn', 'watch'))
    held = hold(section=2, item='WO-1/1', task='watch')
    task_marks = marks(drawn(status(failed, holds=[held])))
    assert task_marks['look'] == '\u2717 failed, continued'
    assert task_marks['turn'] == '\u21bb failed, is tried again'
    assert task_marks['watch'] == '! HELD (hold 1)'


@pytest.mark.parametrize(
    ('end', 'words'),
    [
        (End.DONE, '\u2713 done'),
        (End.MARKED_DONE, '\u2713 marked done'),
        (End.SKIPPED, '\u21b7 skipped'),
        (End.CONTINUED, '\u2717 failed, continued'),
        (End.REJECTED, '\u2717 failed, item rejected'),
        (End.ABORTED, '\u2717 failed, job aborted'),
    ],
)
def test_passed_task_shows_how_it_ended(end: End, words: str) -> None:
    look = PassedTask('look', end, 'this is why')
    prepared = job(passed=(PassedTask('prepare', end),))
    picture = drawn(status(section_2(passed=(look,)), jobs=[prepared]))
    assert picture.words('task.look')[:2] == [words, 'this is why']
    assert marks(picture)['prepare'] == words


def test_mark_says_failed_only_for_failure_ends() -> None:
    for end in End:
        look = section_2(passed=(PassedTask('look', end),))
        assert ('failed' in marks(drawn(status(look)))['look']) is end.is_failure


def test_no_two_marks_are_told_by_colour_alone() -> None:
    texts = [(mark.sign, mark.word) for mark in Mark]
    assert len(set(texts)) == len(texts)


def test_card_shortens_reason_and_tooltip_shows_all() -> None:
    reason = 'waiting for a component with a long name, busy with another task of WO-17/12'
    picture = drawn(status(section_2(waiting=[reason])))
    assert picture.words('task.look')[1].startswith('waiting for a component')
    assert picture.words('task.look')[2].endswith('\u2026')
    assert picture.about('task.look').startswith(f'now: \u2026 waits\n{reason}\n')


def test_a_hold_says_what_may_be_answered() -> None:
    why = 'no reject: the item is rejected already'
    held = hold(section=2, item='WO-1/1', task='look', message='too late', answers_why=why)
    picture = drawn(status(section_2(), holds=[held]))
    hint = picture.about('task.look')
    assert 'timeout (too late); answer with retry | skip' in hint
    assert why in hint
    assert picture.look('task.look').get('stroke-width') == '3'


def test_card_shows_only_whole_sentences_of_hold() -> None:
    message = 'the gripper has lost the item on its way'
    held = hold(section=2, item='WO-1/1', task='look', message=message)
    picture = drawn(status(section_2(), holds=[held]))
    card_text = ' '.join(picture.words('task.look')[1:3])
    assert card_text == f'timeout ({message}) \u2026'
    assert f'timeout ({message}); answer with retry | skip' in picture.about('task.look')


def test_hold_of_whole_cell_appears_in_headline() -> None:
    of_cell = hold(job=None, reason='restarted', answers=('resume',))
    state = line_state(status(holds=[of_cell]), Line().script(SCRIPT), Line().cell)
    assert state.headline.endswith(
        '1 hold, after event 17; hold 1 (restarted): '
        'bt-orchestrator cell resume --hold 1 --reason WHY'
    )


def test_cards_stay_where_they_are() -> None:
    before = drawn(status())
    long = ['a very long reason indeed ' * 8]
    moved = drawn(status(section_2(waiting=long), jobs=[job(), job(), job('WO-3')]))
    cards = [name for name in before.parts if name.startswith('task.') and '-' not in name]
    assert len(cards) == 8
    assert [before.area(name) for name in cards] == [moved.area(name) for name in cards]


# --- initialization and belt ------------------------------------------------------------------


@pytest.mark.parametrize(
    ('fields', 'mark', 'reason'),
    [
        ({'initialization': [statuses.wait('earlier jobs')]}, '\u2026 waits', 'earlier jobs'),
        ({'running': (statuses.task('prepare'),)}, '\u25b6 running', ''),
        ({'running': (statuses.task('other'),)}, '\u2026 waits', ''),
        ({'holds': [hold(task='prepare')]}, '! HELD (hold 1)', 'timeout; answer with'),
    ],
)
def test_initialization(fields: dict[str, Any], mark: str, reason: str) -> None:
    to_come = job(initialization=('prepare',), running=fields.get('running', ()))
    rest = {key: value for key, value in fields.items() if key != 'running'}
    words = drawn(status(jobs=[to_come], **rest)).words('task.prepare')
    assert words[0] == mark
    assert words[1].startswith(reason)


def test_before_there_is_a_job_nothing_is_begun() -> None:
    assert marks(drawn(status(jobs=[])))['prepare'] == 'not begun'


def test_the_belt_while_it_moves() -> None:
    rests, moves = drawn(status()), drawn(status(belt=MOVING))
    assert moves.words('task.index')[0] == '\u25b6 running'
    assert rests.look('belt.1').get('stroke-dasharray') is None
    assert moves.look('belt.1').get('stroke-dasharray') is not None
    assert 'Execute, the belt moves, after event 17' in moves.words('title')
    held = drawn(status(holds=[hold(job=None, task='index')]))
    assert held.words('task.index')[0] == '! HELD (hold 1)'
    assert 'Execute, the belt rests, 1 hold, after event 17' in held.words('title')


# --- slots, flags, jobs -----------------------------------------------------------------------


def test_slots_show_their_item_and_work() -> None:
    picture = drawn(
        status(
            statuses.section(1, waiting=['waiting for the belt to move', 'and more']),
            section_2(),
            changed(statuses.section(3), slot=statuses.item('WO-1/2', empty_position=True)),
        )
    )
    first = picture.words('slot.1')
    assert first == ['slot 1: empty', 'no cycle', 'waiting for the belt to move']
    assert 'and more' in picture.about('slot.1')
    assert picture.words('slot.2')[:2] == ['slot 2: WO-1/1', 'works on WO-1/1']
    assert picture.words('slot.3')[:2] == ['slot 3: (WO-1/2)', 'empty position']


def test_slots_say_what_is_wrong_with_their_items() -> None:
    rejected = section_2(rejected=True, nonconforming=['look'])
    picture = drawn(status(rejected))
    wrong = '\u2717 REJECTED, nonconforming'
    assert picture.words('slot.2')[:2] == ['slot 2: WO-1/1', wrong]
    assert wrong in picture.about('slot.2')


def test_section_names_other_script_it_works_for() -> None:
    other = job('WO-2', script='other')
    running = [statuses.task('look')]
    at_work = statuses.section(2, 'WO-2/1', job='WO-2', running=running)
    picture = drawn(status(at_work, jobs=[job(), other]))
    assert picture.words('slot.2')[1] == 'works on WO-2/1, script other'
    assert marks(picture)['look'] == 'not begun'


def test_what_a_slot_says_stays_in_its_box() -> None:
    long, script = 'WO-1123-1909-PACKING-LEFT-B', 'packing_of_boxes_left'
    running = [statuses.task('look')]
    at_work = changed(
        statuses.section(2, f'{long}/12', job=long, running=running),
        slot=statuses.item(f'{long}/12', rejected=True),
    )
    picture = drawn(status(at_work, jobs=[job(), job(long, script=script)]))
    words = picture.words('slot.2')
    assert max(map(len, words)) <= 34
    assert words[:2] == ['slot 2', f'{long}/12']
    assert words[2] == '\u2717 REJECTED'
    assert words[3].startswith('works on')
    assert words[3].endswith('\u2026')
    whole = changed(at_work, slot=statuses.item('WO-1/1'))
    shown = drawn(status(whole, jobs=[job(), job(long, script=script)]))
    assert max(map(len, shown.words('slot.2'))) <= 34
    assert f'works on {long}/12, script {script}' in picture.about('slot.2')


def test_flags_show_their_counts() -> None:
    assert 'count 1 of 1' in drawn(status()).words('flag.seen')


def test_title_lists_jobs_and_counts_the_rest() -> None:
    jobs = [job(f'WO-{n}', packed=n, rejected=n - 1) for n in range(1, 7)]
    words = drawn(status(jobs=jobs)).words('title')
    assert 'WO-1 (test): Running, 1 of 4 packed' in words
    assert 'WO-2 (test): Running, 2 of 4 packed, 1 rejected' in words
    assert words[-1] == 'and 3 more jobs'


def test_legend_explains_only_shown_marks() -> None:
    rests = drawn(status(section_2(running=[statuses.task('look')])))
    assert '\u25b6 running' in rests.words('legend')
    assert not {'! HELD', 'the belt while it moves'} & set(rests.words('legend'))
    assert 'the belt while it moves' in drawn(status(belt=MOVING)).words('legend')
    assert '! HELD' in drawn(status(holds=[hold(job=None, task='index')])).words('legend')


# --- what is refused --------------------------------------------------------------------------


def test_a_status_of_another_cell() -> None:
    with pytest.raises(NotThisLine, match='of cell other, not of test_line'):
        drawn(status(cell='other'))


def test_live_drawing_shows_that_job_is_aborting() -> None:
    line = Line()
    script = line.script(SCRIPT)
    state = status(jobs=[job(ending='aborting')])
    (job_text,) = line_state(state, script, line.cell).jobs
    assert job_text == 'WO-1 (test): Running, aborting, 0 of 4 packed'
