"""What `what-if` prints of a prediction."""

from __future__ import annotations

from bt_orchestrator.cli.what_if import lines
from bt_orchestrator.ports import Consequence, ExpectedJob

KNOWN = Consequence([ExpectedJob('A', 5.0)], [ExpectedJob('A', 6.0)], ())


def test_what_only_the_node_knows_is_said_below_the_table() -> None:
    asked = KNOWN._replace(refusals=['job.move: J-120 is not there'], notes=['whether …'])
    *_, refused, note, without = lines(asked, left_out=20)
    assert (refused, note) == ('would be refused: job.move: J-120 is not there', 'whether …')
    assert without == (
        'without the last 20 jobs of the queue; a request about one of them is refused here, '
        'and not by the node'
    )


def test_a_prediction_with_all_jobs_is_the_table_alone() -> None:
    assert len(list(lines(KNOWN))) == 2
