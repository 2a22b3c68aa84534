"""Where the state of a picture comes from, and how long it is followed."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.cli.live_picture import CannotRead, Course, saved_status


def test_a_saved_status_is_read(tmp_path: Path) -> None:
    file = tmp_path / 'status.json'
    file.write_text('{"cell": "a"}')
    assert saved_status(file) == {'cell': 'a'}


@pytest.mark.parametrize(
    ('text', 'words'),
    [(None, 'cannot read'), ('{', 'is no JSON'), ('[1]', 'holds no JSON object')],
)
def test_a_file_that_holds_none(text: str | None, words: str, tmp_path: Path) -> None:
    file = tmp_path / 'status.json'
    if text is not None:
        file.write_text(text)
    with pytest.raises(CannotRead, match=words):
        saved_status(file)


def jobs(*states: str, script: str = 'a') -> dict[str, object]:
    return {'jobs': [{'script': script, 'state': state} for state in states]}


def test_it_is_over_when_the_jobs_of_the_script_have_ended() -> None:
    course = Course('a')
    for status in (jobs(), jobs('Ended'), jobs('Ended', 'AllowedToStart'), jobs('Running')):
        course.look(status)
        assert not course.is_over
    course.look(jobs('Ended', 'Aborted'))
    assert course.is_over


def test_jobs_of_other_scripts_do_not_count() -> None:
    course = Course('a')
    course.look(jobs('Running'))
    course.look(jobs('Running', script='b'))
    assert course.is_over
