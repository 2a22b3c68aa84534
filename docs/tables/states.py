"""The states of the cell and of jobs, the methods of jobs, stop reasons, kinds of faults."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model.fault import FaultKind
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import ANOTHER, METHODS, REQUEUE, Method
from bt_orchestrator.model.packml import MEANINGS, TRANSITIONS, VERBS, Cause, PackmlState
from bt_orchestrator.model.stop_reason import WORDS, StopReason
from tables import docstrings
from tables.markdown import cell, table


def states_of_the_cell() -> Iterator[str]:
    """Yield what every state means."""
    titles = ('state', 'means', 'cycles begin', 'cycles in hand go on')
    rows = ((m.value, MEANINGS[m], _yes(m.begins), _yes(m.works)) for m in PackmlState)
    yield from table(titles, rows)


def commands_in_states() -> Iterator[str]:
    """Yield the table of transitions: commands, and what the cell does by itself."""
    yield from table(
        ('in', *(f'`{verb}`' for verb in VERBS.values()), 'by itself'),
        (
            (
                mode.value,
                *(row[cause].value if cause in row else '-' for cause in VERBS),
                ', '.join(row[cause].value for cause in _BY_ITSELF if cause in row),
            )
            for mode, row in TRANSITIONS.items()
        ),
    )


_BY_ITSELF = (Cause.SUSPEND, Cause.UNSUSPEND, Cause.DONE)


def stop_reasons() -> Iterator[str]:
    """Yield every stop reason in both vocabularies."""
    documented = docstrings.of_members(StopReason)
    yield from table(
        ('reason', 'means', 'to the cell', 'jobs on the line'),
        (
            (
                reason.value,
                cell(documented[reason.value]),
                words.cell.value,
                f'Interrupted / {words.job.value}',
            )
            for reason, words in WORDS.items()
        ),
    )


_ALL = (*METHODS, REQUEUE, ANOTHER)


def methods_of_a_job() -> Iterator[str]:
    """Yield what every method of a job does."""
    titles = ('method', '`queue ...`', 'does')
    yield from table(titles, ((m.name, f'`{m.verb}`', cell(m.meaning)) for m in _ALL))


def states_of_a_job() -> Iterator[str]:
    """Yield which state follows from which method in which state."""
    titles = ('', *(word.value for word in JobWord))
    rows = ((m.name, *(_after(m, word) for word in JobWord)) for m in _ALL[2:])
    yield from table(titles, rows)


def kinds_of_faults() -> Iterator[str]:
    """Yield what a simulated controller can do wrong."""
    meanings = docstrings.of_members(FaultKind).items()
    titles = ('kind', 'what happens')
    yield from table(titles, ((f'`{kind}`', cell(meaning)) for kind, meaning in meanings))


def _after(method: Method, before: JobWord) -> str:
    if before not in method.changes:
        return ''
    after = method.changes[before]
    return 'no longer listed' if after is None else after.value


def _yes(answer: bool) -> str:
    return 'yes' if answer else 'no'
