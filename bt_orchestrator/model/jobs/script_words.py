"""What a job runs, in words, for all surfaces."""

from __future__ import annotations

from typing import Protocol


class Made(Protocol):
    """A job, as far as it is told what it runs."""

    @property
    def script(self) -> str:
        """Name of its script."""

    @property
    def recipe(self) -> str:
        """Name of the recipe that this was generated from; empty: none."""

    @property
    def recipe_version(self) -> int | None:
        """Version of the recipe; None: not known."""


def script_words(job: Made) -> str:
    """Name what a job runs: its script, and the recipe that this was generated from."""
    if not job.recipe:
        return job.script
    version = '' if job.recipe_version is None else f' version {job.recipe_version}'
    return f'{job.script} from {job.recipe}{version}'
