"""Several orders in files: each needs an id of its own."""

from __future__ import annotations

from collections.abc import Sequence

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.script.orders.order_file import OrderFile, OrderPlaces


def refuse_duplicates(files: Sequence[OrderFile]) -> None:
    """Refuse orders with the id of an order in front of them (formats: work order).

    :raises Refused: with each of them
    """
    first: dict[str, OrderPlaces] = {}
    findings = []
    for file in files:
        name, places = file.order.order, file.places
        if name is not None and first.setdefault(name, places) is not places:
            place = places.place('order')
            before = f'{first[name].file}:{first[name].place("order").line}'
            what = f'the order `{name}` was given before, in {before}'
            findings.append(
                Finding(places.file, place.line, place.column, what, 'choose another id')
            )
    if findings:
        raise Refused(findings)
