"""Task lists: sections, steps, groups, default ids."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.script_texts import line, mistakes

from bt_orchestrator.model.limits import INITIALIZATION
from bt_orchestrator.model.script import Release


@pytest.mark.parametrize(('text', 'expected'), table('sections'))
def test_sections(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


@pytest.mark.parametrize(('text', 'expected'), table('groups'))
def test_groups_and_initialization(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


@pytest.mark.parametrize(('text', 'expected'), table('repeats'))
def test_repeats(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


@pytest.mark.parametrize(('text', 'expected'), table('ids'))
def test_ids(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


def test_steps_tracks_and_default_ids_follow_list_order() -> None:
    read = line(
        '  2:\n'
        '    - {task: RUN, action: /camera/task}\n'
        '    - parallel:\n'
        '      - {task: RUN, action: /lamp/task}\n'
        '      - [{task: RUN, action: /camera/task}, {id: x, task: RUN, action: /camera/task}]\n'
        '    - {task: STOP, action: /camera/task}\n'
        'initialization: [{id: home, task: RUN, action: /lamp/task}, {action: /cart/drive}]\n'
    )
    steps = read.sections[2].steps
    assert [[[task.id for task in track] for track in step.tracks] for step in steps] == [
        [['2.1']],
        [['2.2'], ['2.3', 'x']],
        [['2.5']],
    ]
    assert [task.id for task in read.initialization] == ['home', 'init.2']


def test_ids_are_the_text_as_written() -> None:
    read = line(
        '  2: [{id: 4.10, task: RUN, action: /camera/task},\n'
        '    {id: 4.1, task: RUN, action: /camera/task}, {id: yes, action: /cart/drive}]\n'
    )
    assert [task.id for task in read.sections[2].tasks] == ['4.10', '4.1', 'yes']


def test_a_section_may_be_a_mapping() -> None:
    read = line(
        '  2:\n'
        '    release_conveyor: after_last_conveyor_task\n'
        '    tasks:\n'
        '      - {task: RUN, action: /camera/task}\n'
        '      - {task: RUN, action: /camera/task, requires_conveyor: false}\n'
    )
    assert read.sections[2].release is Release.AFTER_LAST_CONVEYOR_TASK
    assert read.sections[2].turn_steps == 1


def test_sections_are_in_the_order_of_the_belt() -> None:
    assert [*line('  2: [{task: RUN, action: /camera/task}]\n').sections] == [1, 2, 4]


def test_initialization_has_an_upper_limit() -> None:
    """All of it waits at a time, and each of its tasks is looked at in every tick."""

    def whole(number: int) -> str:
        tasks = ''.join(
            f'  - {{id: i{n}, task: RUN, action: /camera/task}}\n' for n in range(number)
        )
        return f'initialization:\n{tasks}'

    assert mistakes(lambda: line(whole(INITIALIZATION))) == []
    (finding,) = mistakes(lambda: line(whole(INITIALIZATION + 2)))
    assert finding.endswith(
        f'initialization has more than {INITIALIZATION} tasks; let a section do the others'
    )
