"""Work orders: reading one from a file, and binding one to its script (formats: work order)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import MOST_ITEMS
from bt_orchestrator.model.jobs.order import Job, WorkOrder
from bt_orchestrator.model.script import Parameter, Script
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.field_types import PARAMETER_TYPES, misfit
from bt_orchestrator.script.fields import Fields, file_fields
from bt_orchestrator.script.keys import LARGEST_WHOLE
from bt_orchestrator.script.names import wrong_order_id
from bt_orchestrator.script.orders.parameter_uses import misfitting_uses
from bt_orchestrator.script.orders.terms import Wrong, read_choice, read_terms, wrong_terms
from bt_orchestrator.script.report import START, Place, Report, did_you_mean, listing, nearest
from bt_orchestrator.script.script_keys import ORDER
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import (
    MapNode,
    Scalar,
    found,
    found_value,
    plain_value,
    quoted,
    shortened,
)


def path_of(key: str) -> tuple[str, ...]:
    """Return the path of a key: params.lot is `lot` in `params`."""
    return tuple(key.split('.', 1))


def key_in(key: str) -> str:
    """Return a key as findings name it: without colons, which separate line and column."""
    return shortened(key).replace(':', '_')


@dataclass(frozen=True)
class OrderPlaces:
    """Where an order's keys stand: mistakes found later point there too."""

    file: str
    """File name, or a word for an order that came in another way."""
    places: Mapping[tuple[str, ...], Place] = field(default_factory=dict)
    """By path: ('quantity',), ('params', 'lot')."""
    findings: tuple[Finding, ...] = ()
    """Mistakes that the file has, whatever its script is."""
    doubted: frozenset[tuple[str, ...]] = frozenset()
    """Paths of what these mistakes are about: nothing is built on it."""

    def place(self, *path: str) -> Place:
        """Return the place of a key, or of the nearest one around it."""
        while path and path not in self.places:
            path = path[:-1]
        return self.places.get(path, START)

    def finding(self, wrong: Wrong) -> Finding:
        """Return a mistake in one of the keys, which is named where there is no file."""
        place = self.place(*path_of(wrong.key))
        file = self.file if self.places or not wrong.key else f'{self.file}, {key_in(wrong.key)}'
        return Finding(file, place.line, place.column, wrong.what, wrong.hint, wrong.key)

    def is_sure(self, *path: str) -> bool:
        """Tell whether a key, and all around it, has been read as it was meant."""
        return not any(path[:length] in self.doubted for length in range(1, len(path) + 1))


@dataclass(frozen=True)
class OrderFile:
    """A work order as read from a file."""

    order: WorkOrder
    places: OrderPlaces


def read_order(path: Path) -> OrderFile:
    """Read a work order.

    :raises Refused: with every mistake in it
    """
    return _without_mistakes(draft_order(path))


def draft_order(path: Path) -> OrderFile:
    """Read a work order that may have mistakes; `bind_order` tells them with its own.

    :raises Refused: it is no work order at all
    """
    return parse_draft(read_text(path), str(path))


def parse_order(text: str, file: str) -> OrderFile:
    """Read the text of a work order; the file's name stands in the findings.

    :raises Refused: with every mistake in it
    """
    return _without_mistakes(parse_draft(text, file))


def parse_draft(text: str, file: str) -> OrderFile:
    """Read the text of a work order as `draft_order` does.

    :raises Refused: it is no work order at all
    """
    report = Report(file)
    fields = file_fields(text, ORDER, report)
    places = _places(fields)
    doubted: set[tuple[str, ...]] = set()
    params = _params(fields, places, doubted, report)
    order_id = fields.text('order')
    wrong_id = None if order_id is None else wrong_order_id(order_id)
    if wrong_id is not None:
        report.add(fields.place('order'), *wrong_id)
    script, quantity = fields.text('script') or '', fields.optional_whole('quantity')
    recipe = read_choice(fields)
    order = WorkOrder(script, order_id, quantity, params, read_terms(fields), recipe)
    doubted |= {(key,) for key in ORDER.by_name if not fields.is_sure(key)}
    if params:
        doubted.discard(('params',))
    return OrderFile(order, OrderPlaces(file, places, report.findings, frozenset(doubted)))


def is_order(path: Path) -> bool:
    """Tell whether a file is meant as a work order; one that cannot be read is none."""
    try:
        root = compose(read_text(path), Report(str(path)))
    except Refused:
        return False
    keys = {entry.key.text for entry in root.entries} if isinstance(root, MapNode) else set()
    if keys & {'sections', 'operations', 'conveyor', 'components', 'set'}:
        return False
    return 'order' in keys or {'script', 'quantity'} <= keys or {'recipe', 'quantity'} <= keys


def _without_mistakes(order: OrderFile) -> OrderFile:
    if order.places.findings:
        raise Refused(order.places.findings)
    return order


def bind_order(
    order: WorkOrder,
    script: Script,
    job_id: str,
    places: OrderPlaces | None = None,
    types: Mapping[str, ActionType] | None = None,
    most_items: int = MOST_ITEMS,
) -> Job:
    """Make a job of an order: check it against its script and fill in what it leaves open.

    Without places (an order that came over a service) findings name the order instead of a file.
    Of the cell, `most_items` limits the quantity.
    With the types of the cell's components (`action_types`), values are checked against every goal
    field that they go into; without, a value that does not fit fails when its goal is sent.

    :raises Refused: with every mistake in the order
    """
    places = places or named_places(order.order or job_id)
    report = Report(places.file)
    report.take(places.findings)
    wrong_id = None if order.order is None else wrong_order_id(order.order)
    if wrong_id is not None:
        report.keep(places.finding(Wrong('order', *wrong_id)))
    quantity = _quantity(order, script, places, most_items, report)
    misspelt = _check_names(order, script, places, report)
    params = {
        name: _bound(parameter, order, places, report)
        for name, parameter in script.params.items()
        if name not in misspelt
    }
    for wrong in wrong_terms(order.terms):
        if places.is_sure(wrong.key):
            report.keep(places.finding(wrong))
    if types is not None:
        for use in misfitting_uses(script, order.order or job_id, quantity, params, types):
            report.keep(places.finding(Wrong('.'.join(use.path), use.what, use.hint)))
    report.refuse()
    return Job(job_id, script, quantity, params, order.terms, order.recipe)


def named_places(name: str) -> OrderPlaces:
    """Return the places of an order that came without a file: findings name the order."""
    return OrderPlaces(f'order {quoted(name)[1:-1]}')


def param_from_text(text: str, parameter: Parameter) -> Any:
    """Convert a value that arrived as text, written as in YAML, to a parameter's type.

    A text parameter takes the text as it is, without the quotes around it if there are any. A text
    that does not fit is returned unchanged: `bind_order` reports it with all other mistakes.
    """
    if parameter.type == 'str':
        is_quoted = len(text) > 1 and text[0] == text[-1] and text[0] in '"\''
        return text[1:-1] if is_quoted else text
    value = plain_value(text.strip())
    return text if value is None else value


def params_from_text(texts: Mapping[str, str], script: Script) -> dict[str, Any]:
    """Convert the values of an order that arrived as text; unknown names keep theirs."""
    return {
        name: param_from_text(text, script.params[name]) if name in script.params else text
        for name, text in texts.items()
    }


def _places(fields: Fields) -> dict[tuple[str, ...], Place]:
    places: dict[tuple[str, ...], Place] = {(): fields.node.place}
    for key in ORDER.by_name:
        if fields.has(key):
            places[(key,)] = fields.place(key)
    return places


def _params(
    fields: Fields,
    places: dict[tuple[str, ...], Place],
    doubted: set[tuple[str, ...]],
    report: Report,
) -> dict[str, Any]:
    node = fields.mapping('params')
    doubted |= {('params', name) for name in (node.doubtful if node else ())}
    params: dict[str, Any] = {}
    for entry in node.entries if node else ():
        name = entry.key.text
        places['params', name] = entry.value.place
        if isinstance(entry.value, Scalar) and entry.value.value is not None:
            params[name] = entry.value.value
        else:
            doubted.add(('params', name))
            params[name] = None
            what = (
                f'the parameter {quoted(name)} must be one plain value, not {found(entry.value)}'
            )
            report.add(entry.value.place, what, 'write text, a number, true or false')
    return params


def _quantity(
    order: WorkOrder, script: Script, places: OrderPlaces, most: int, report: Report
) -> int:
    quantity = script.quantity if order.quantity is None else order.quantity
    if not places.is_sure('quantity'):
        return 1
    if quantity is None:
        what = f'the order names no quantity, and the script `{script.name}` has no default'
        report.keep(places.finding(Wrong('quantity', what, 'add for instance `quantity: 12`')))
        return 1
    if type(quantity) is not int or not 1 <= quantity <= LARGEST_WHOLE:
        what = sentence('quantity', most=LARGEST_WHOLE, given=found_value(quantity))
        report.keep(places.finding(Wrong('quantity', what, sentence('one_item'))))
        return 1
    if quantity > most:
        report.keep(places.finding(Wrong('quantity', *wrong_quantity(quantity, most))))
        return 1
    return quantity


def wrong_quantity(quantity: int, most: int) -> tuple[str, str]:
    """Say that a cell takes no order of so many items, and what to do."""
    return sentence('most_items', quantity=quantity, most=most), sentence('less_items')


def _check_names(
    order: WorkOrder, script: Script, places: OrderPlaces, report: Report
) -> set[str]:
    """Report unknown parameters; return those that were probably meant, so not missing."""
    meant = set()
    for name in order.params:
        if name not in script.params:
            known = listing(script.params)
            otherwise = f'its parameters are {known}' if known else 'it has none; remove this'
            hint = did_you_mean(name, script.params, otherwise)
            what = f'the script `{script.name}` has no parameter {quoted(name)}'
            report.keep(places.finding(Wrong(f'params.{name}', what, hint)))
            meant.add(nearest(name, script.params) or '')
    return meant - set(order.params)


def _bound(parameter: Parameter, order: WorkOrder, places: OrderPlaces, report: Report) -> Any:
    """Return a parameter's value: the order's, else the default."""
    name = parameter.name
    if not places.is_sure('params', name):
        return parameter.default
    if name not in order.params:
        if parameter.required:
            what = sentence('param_missing', name=name)
            hint = sentence('param_add', name=name, type=parameter.type)
            report.keep(places.finding(Wrong(f'params.{name}', what, hint)))
        return parameter.default
    value = order.params[name]
    problem = misfit(value, PARAMETER_TYPES[parameter.type])
    if problem is not None:
        what = sentence('param', name=name, needed=problem.needed, given=found_value(value))
        report.keep(places.finding(Wrong(f'params.{name}', what, problem.hint)))
        return None
    return float(value) if parameter.type == 'float' else value
