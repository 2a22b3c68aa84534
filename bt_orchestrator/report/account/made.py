"""What was made, by job."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.jobs.job_record import BY_HAND, PACKED


@dataclass
class Made:
    """Items of one job that left the line."""

    job: str
    script: str = ''
    digest: str = ''
    recipe: str = ''
    recipe_version: int | None = None
    good: int = 0
    nonconforming: int = 0
    """Packed, although a task failed or was let pass."""
    rejected: int = 0
    by_hand: int = 0
    """Taken off the belt by an operator."""
    outside: int = 0
    """Of whatever kind, but not in planned time: in none of the other counts."""

    @property
    def produced(self) -> int:
        """All that were made in planned time (ISO 22400: produced quantity)."""
        return self.good + self.bad

    @property
    def has_any(self) -> bool:
        """Tell whether anything left the line."""
        return bool(self.produced or self.outside)

    @property
    def bad(self) -> int:
        """Those that are not good."""
        return self.nonconforming + self.rejected + self.by_hand


class MadeFold:
    """Takes in one event after another; keeps of an item only that it is nonconforming."""

    def __init__(self) -> None:
        self._jobs: dict[str, Made] = {}
        self._nonconforming: set[str] = set()

    def follow(self, event: e.Event, *, counts: bool, is_planned: bool) -> None:
        """Take in the next event.

        :param counts: it is in the period
        :param is_planned: it is in planned time
        """
        if isinstance(event, (e.JobQueued, e.JobUpdated)):
            self._jobs[event.job] = Made(
                event.job, event.script, event.digest, event.recipe, event.recipe_version
            )
        elif isinstance(event, e.ItemNonconforming):
            self._nonconforming.add(event.item)
        elif isinstance(event, e.TaskContinued):
            if event.item is not None and event.policy == OnFailure.CONTINUE.value:
                self._nonconforming.add(event.item)
        elif isinstance(event, e.ItemRemoved):
            is_bad = event.item in self._nonconforming
            self._nonconforming.discard(event.item)
            if counts:
                made = self._jobs.setdefault(event.job, Made(event.job))
                _count(made, event.how, is_bad=is_bad, is_planned=is_planned)
        elif isinstance(event, (e.JobCompleted, e.JobAborted, e.JobRemoved)):
            ended = self._jobs.get(event.job)
            if ended is not None and not ended.has_any:
                del self._jobs[event.job]

    def made(self) -> tuple[Made, ...]:
        """Return the jobs of which anything left the line, in the order queued."""
        return tuple(replace(one) for one in self._jobs.values() if one.has_any)


def _count(made: Made, how: str, *, is_bad: bool, is_planned: bool) -> None:
    if not is_planned:
        made.outside += 1
    elif how == PACKED and not is_bad:
        made.good += 1
    elif how == PACKED:
        made.nonconforming += 1
    elif how == BY_HAND:
        made.by_hand += 1
    else:
        made.rejected += 1


FOLLOWED = (
    e.ItemNonconforming.event,
    e.TaskContinued.event,
    e.ItemRemoved.event,
)
