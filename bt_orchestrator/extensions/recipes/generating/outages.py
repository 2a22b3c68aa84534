"""The output and pace of the line while one component is out of service: for planners."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.base.errors import counted
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.generating.making import judge_of, plan
from bt_orchestrator.extensions.recipes.planning.outcome import Generated, NotFound, NotMade
from bt_orchestrator.model.jobs.made_anew import compared_words
from bt_orchestrator.model.script import Script


@dataclass(frozen=True)
class Outage:
    """The line without one component."""

    component: str
    per_item_s: float | None = None
    """None: the product cannot be made, or it is not known how."""
    slower: float = 0.0
    """As a part of the time with all components."""
    elsewhere: tuple[str, ...] = ()
    """Operations that are done elsewhere."""
    only_there: tuple[str, ...] = ()
    """Operations that no other component can do."""
    reasons: tuple[str, ...] = ()
    """Why not."""
    is_proven: bool = True
    """The script cannot be made."""

    @property
    def words(self) -> str:
        """The consequences."""
        if self.per_item_s is None:
            verdict = 'not to be made' if self.is_proven else 'not known'
            why = f'{", ".join(self.only_there)} only there' if self.only_there else ''
            return f'{verdict}: {why or "; ".join(self.reasons)}'
        return compared_words(self.per_item_s, self.slower)


def outages(
    inputs: Inputs, whole: Generated, without: frozenset[str], keep: Script | None
) -> Iterator[Outage]:
    """Yield what comes of each component's outage, in the order of the cell file.

    :param whole: the script with all that are in service
    :param without: components that are out of service in any case
    """
    judge = judge_of(inputs)
    for name, component in inputs.cell.components.items():
        if not component.capabilities or name in without:
            continue
        try:
            found = plan(inputs, without | {name}, keep, judge)
        except NotMade as fault:
            is_proven = not isinstance(fault, NotFound)
            lost = _only_at(name, whole)
            yield Outage(name, only_there=lost, reasons=fault.reasons, is_proven=is_proven)
        else:
            seconds, before = found.claim.per_item_s, whole.claim.per_item_s
            slower = seconds / before - 1 if before else 0.0
            yield Outage(name, seconds, slower, moved(whole.script, found))


def _only_at(component: str, whole: Generated) -> tuple[str, ...]:
    facts = (one for one in whole.made.values() if one.capability and not one.alternatives)
    return tuple(one.operation for one in facts if one.component == component)


def moved(old: Script, now: Generated) -> tuple[str, ...]:
    """Return the operations that are done elsewhere than in a script."""
    return tuple(
        task
        for task, one in now.made.items()
        if one.capability
        and (
            task not in old.tasks
            or old.tasks[task].component != one.component
            or old.section_of(task) != one.section
        )
    )


def outage_lines(whole: Generated, found: Sequence[Outage]) -> Iterator[str]:
    """Yield a table."""
    rows = [('all in service', f'{whole.claim.per_item_s:.1f} s per item', '')]
    for one in found:
        moved = f'{counted(len(one.elsewhere), "operation")} elsewhere' if one.elsewhere else ''
        rows.append((one.component, one.words, moved))
    width = max(len(out) for out, _, _ in rows)
    for out, words, moved in rows:
        yield f'{out.ljust(width)}  {words}{", " if moved else ""}{moved}'


def plain_outages(whole: Generated, found: Sequence[Outage]) -> Mapping[str, Any]:
    """Return them as data that JSON can carry."""
    each = [{**vars(one), 'words': one.words} for one in found]
    return {'ok': True, 'per_item_s': whole.claim.per_item_s, 'without': each}
