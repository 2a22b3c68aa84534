"""The reasons in a generated script, for a person and for programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bt_orchestrator.base.errors import counted
from bt_orchestrator.cli.check import summary
from bt_orchestrator.cli.pacing import Pacing
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.generating.making import Made, reason_remark
from bt_orchestrator.extensions.recipes.planning.outcome import Generated, NotFound, NotMade, Price
from bt_orchestrator.extensions.recipes.planning.outcome import Made as Fact


@dataclass(frozen=True)
class Kept:
    """An old script that was mostly kept, and the script without regard to it."""

    old: str
    moved: Sequence[str]
    """Operations that are done elsewhere than in it."""
    freely: Generated
    moved_freely: Sequence[str]


def summary_lines(made: Made, inputs: Inputs, kept: Kept | None) -> Iterator[str]:
    """Yield what was generated, and how fast it is."""
    script = made.generated.script
    yield from summary(script, inputs.cell, Pacing(inputs.cell, inputs.types).of(script))
    yield f'  {made.generated.claim}'
    if kept is not None:
        here, freely = made.generated.claim, kept.freely.claim
        moved = counted(len(kept.moved), 'operation')
        yield f'  {moved} elsewhere than in {kept.old}, {here.per_item_s:.1f} s for each item'
        moved = counted(len(kept.moved_freely), 'operation')
        yield f'  without --keep: {moved} elsewhere, {freely.per_item_s:.1f} s for each item'


Prices = Mapping[str, Sequence[Price]]
"""By operation: what each other component would cost."""


def explanation(made: Made, prices: Prices) -> Iterator[str]:
    """Yield a table of the tasks: where each is done, as what, and why there, and the prices."""
    headers = ('operation', 'section', 'component', 'capability', 'why')
    facts = [fact for fact in made.generated.made.values() if fact.capability]
    rows = [
        (fact.operation, str(fact.section), fact.component, fact.capability, _why(fact, prices))
        for fact in facts
    ]
    widths = [max(map(len, column)) for column in zip(headers, *rows, strict=True)]
    for row in (headers, *rows):
        cells = (text.ljust(width) for text, width in zip(row, widths, strict=True))
        yield '  '.join(cells).rstrip()


def _why(fact: Fact, prices: Prices) -> str:
    texts = [f'{price.component}: {price.words}' for price in prices.get(fact.operation, ())]
    return '; '.join([fact.why.value, *texts]) if texts else reason_remark(fact)


def plain(
    made: Made, inputs: Inputs, kept: Kept | None, file: str | None, prices: Prices
) -> Mapping[str, Any]:
    """Return it as data that JSON can carry."""
    script, claim = made.generated.script, made.generated.claim
    fields: dict[str, Any] = {
        'ok': True,
        'script': script.name,
        'made_from': vars(made.made_from),
        'file': file,
        'text': made.text,
        'per_item_s': claim.per_item_s,
        'is_fastest': claim.is_fastest,
        'bound_s': claim.bound_s,
        'gap': claim.gap,
        'pace': Pacing(inputs.cell, inputs.types).of(script).plain(),
        'tasks': [_task(task, fact) for task, fact in made.generated.made.items()],
    }
    if prices:
        fields['prices'] = {
            name: [{**vars(way), 'words': way.words} for way in ways]
            for name, ways in prices.items()
        }
    if kept is not None:
        freely = kept.freely.claim.per_item_s
        fields['moved'] = list(kept.moved)
        fields['without_keep'] = {'per_item_s': freely, 'moved': list(kept.moved_freely)}
    return fields


def plain_reasons(fault: NotMade) -> Mapping[str, Any]:
    """Return why there is no script, as data that JSON can carry."""
    reasons = list(fault.reasons)
    return {'ok': False, 'reasons': reasons, 'proven': not isinstance(fault, NotFound)}


def _task(task: str, fact: Fact) -> Mapping[str, Any]:
    names = ('operation', 'capability', 'component', 'section')
    facts = {name: getattr(fact, name) for name in names}
    others = list(fact.alternatives)
    return {'task': task, **facts, 'why': fact.why.value, 'alternatives': others}
