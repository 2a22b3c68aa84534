"""Preparations of a cell against each other: their ids, and which comes first."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from bt_orchestrator.model.capability import Preparation
from bt_orchestrator.script.checks.circles import circles
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import quoted


class Prepared(NamedTuple):
    """A component that is prepared."""

    component: str
    preparation: Preparation
    fields: Fields


def check_preparations(
    prepared: Sequence[Prepared], components: Collection[str], report: Report
) -> None:
    """Report ids given twice, waits for nothing, and preparations that wait for each other."""
    ids: dict[str, Prepared] = {}
    for one in prepared:
        first = ids.setdefault(one.preparation.id, one)
        if first is not one and one.preparation.id:
            what = f'the id `{one.preparation.id}` is given twice'
            line = first.fields.place('id').line
            hint = f'rename one; the first is in line {line}'
            report.add(one.fields.place('id'), what, hint)
        _check_after(one, prepared, components, report)
    waits = [(name, one.component) for one in prepared for name in one.preparation.after]
    for circle in circles(waits):
        last = next(one for one in prepared if one.component == circle[-1])
        what = f'preparations wait for each other: {", ".join(circle)}'
        report.add(last.fields.place('after'), what, 'remove one of the waits')


def _check_after(
    one: Prepared, prepared: Sequence[Prepared], components: Collection[str], report: Report
) -> None:
    known = [other.component for other in prepared]
    for name in one.fields.names('after'):
        if name.text in known:
            continue
        if name.text in components:
            what = f'`{name.text}` has no preparation to wait for'
            hint = f'give it `prepare`, or remove {quoted(name.text)} here'
        else:
            what = f'there is no component {quoted(name.text)}'
            hint = did_you_mean(
                name.text, components, f'those that are prepared are {listing(known)}'
            )
        report.add(name.place, what, hint)
