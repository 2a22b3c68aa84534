"""The script that a job ran, as a file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.keeping.journal_place import JournalPlace
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.writing.script_text import Comments, write_script
from bt_orchestrator.view.report.reading import Reading


class NoScript(OrchestratorError):
    """A journal does not have the script of a job any more."""


def script_of(job: JobRecord, reading: Reading, journal: JournalPlace) -> Iterator[str]:
    """Yield the text of the script that a job ran.

    :raises NoScript: the journal has it no more
    """
    script = reading.script(job.digest) if job.digest else None
    if script is None:
        raise NoScript(
            f'the script of {job.job} is not kept any more in {journal}; a backup of the journal '
            'may have it'
        )
    if _origin(script) != (job.recipe, job.recipe_version):
        script = replace(script, made_from=None)  # an equal one, of another version of the recipe
    head = [
        f'The script that job {job.job} ran, by the journal, with the time limits of components.'
    ]
    if job.params:
        head.append(f'Its parameters: {json_of(job.params)}')
    yield write_script(script, None, Comments(head)).rstrip()


def _origin(script: Script) -> tuple[str, int | None]:
    made_from = script.made_from
    return (made_from.recipe, made_from.version) if made_from else ('', None)
