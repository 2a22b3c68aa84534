"""The losses of an account."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.view.report.account.losses import WORDS
from tables.markdown import cell, code, table


def losses() -> Iterator[str]:
    """Yield what each loss means, in the order of the waterfall."""
    yield from table(
        ('loss', 'in JSON', 'counts against', 'time in which'),
        (
            (words.title, code(loss.value), words.step.value, cell(words.meaning))
            for loss, words in WORDS.items()
        ),
    )
