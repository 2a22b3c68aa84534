"""Where the state of a picture comes from, and how long it is followed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from fakes import statuses

from bt_orchestrator.cli.render import CannotRead, Course, saved_status
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus


def test_a_saved_status_is_read(tmp_path: Path) -> None:
    file = tmp_path / 'status.json'
    status = statuses.status(holds=[statuses.hold()], state_times={PackmlState.HELD: 2.5})
    file.write_text(json.dumps(to_plain(status, whole=True)))
    assert saved_status(file) == status


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        (None, 'cannot read'),
        ('{', 'is not JSON'),
        ('[1]', 'holds no status of a cell'),
        ('{}', 'holds no status of a cell'),
        ('{"cell": "a", "is_there": true}', 'holds no status of a cell'),
    ],
)
def test_a_file_that_holds_none(text: str | None, words: str, tmp_path: Path) -> None:
    file = tmp_path / 'status.json'
    if text is not None:
        file.write_text(text)
    with pytest.raises(CannotRead, match=words):
        saved_status(file)


def jobs(*states: JobWord, script: str = 'small') -> CellStatus:
    entries = [changed(statuses.job(state=state), script=script) for state in states]
    return statuses.status(jobs=entries)


def test_course_ends_when_jobs_of_script_end() -> None:
    course = Course('small')
    waiting, ended = JobWord.ALLOWED_TO_START, JobWord.ENDED
    for status in (jobs(), jobs(ended), jobs(ended, waiting), jobs(JobWord.RUNNING)):
        course.look(status)
        assert not course.is_over
    course.look(jobs(ended, JobWord.ABORTED))
    assert course.is_over


def test_jobs_of_other_scripts_do_not_count() -> None:
    course = Course('small')
    course.look(jobs(JobWord.RUNNING))
    course.look(jobs(JobWord.RUNNING, script='b'))
    assert course.is_over
