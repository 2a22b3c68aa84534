"""What `what-if` prints of a prediction."""

from __future__ import annotations

import pytest

from bt_orchestrator.cli.what_if import lines
from bt_orchestrator.ports import Consequence, ExpectedJob

KNOWN = Consequence([ExpectedJob('A', 5.0)], [ExpectedJob('A', 6.0)], ())


def test_refusals_and_notes_follow_the_table() -> None:
    asked = KNOWN._replace(refusals=['job.move: J-120 is not there'], notes=['whether …'])
    *_, refused, note, without = lines(asked, left_out=20)
    assert (refused, note) == ('would be refused: job.move: J-120 is not there', 'whether …')
    assert without == (
        'without the last 20 jobs of the queue; a request about one of them is refused here, '
        'and not by the node'
    )


def test_complete_prediction_is_table_alone() -> None:
    assert len(list(lines(KNOWN))) == 2


@pytest.mark.parametrize(
    ('before_s', 'after_s', 'word', 'shown'),
    [
        (5.0, 9.0, 'later', '+4.0 s'),
        (9.0, 5.0, 'earlier', '-4.0 s'),
        (5.0, 5.9, 'same', '='),
        (None, None, 'never', '-'),
        (5.0, None, 'open', '-'),
        (None, 5.0, 'known', '-'),
    ],
)
def test_a_change_has_one_word_everywhere(
    before_s: float | None, after_s: float | None, word: str, shown: str
) -> None:
    result = KNOWN._replace(before=[ExpectedJob('A', before_s)], after=[ExpectedJob('A', after_s)])
    assert [entry.change for entry in result.changes] == [word]
    assert list(lines(result))[1].endswith(f' {shown}')


def test_jobs_on_one_side_are_new_or_gone() -> None:
    result = Consequence([ExpectedJob('A', 5.0)], [ExpectedJob('B', None)], ())
    assert {entry.job: entry.change for entry in result.changes} == {'A': 'gone', 'B': 'new'}
