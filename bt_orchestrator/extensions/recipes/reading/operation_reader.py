"""Reading the operations of a recipe: what each does, by whom, and in which order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from bt_orchestrator.extensions.recipes.reading.shelf import (
    Candidate,
    OperationDraft,
    RecipeDraft,
    given_by_all,
)
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.limits import OPERATIONS
from bt_orchestrator.model.script import Task
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.structure import circles
from bt_orchestrator.script.drafts import Position, RepeatDraft
from bt_orchestrator.script.fields import Fields, fields_of
from bt_orchestrator.script.orders.recipe_keys import OPERATION, REWORK
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing, nearest
from bt_orchestrator.script.task_reader import read_id, written_options
from bt_orchestrator.script.yaml_nodes import MapNode, Node, Scalar, quoted

_NAMELESS = '?'
"""No id begins so."""


class _Listed(NamedTuple):
    """An operation whose relations to others are not known yet."""

    id: str
    fields: Fields
    above: str | None
    is_member: bool = False
    """Of a repeat, and not its first operation: it is always after the one above."""


class _Repeated(NamedTuple):
    """A repeat whose operations are not put together yet."""

    members: Sequence[str]
    times: int
    place: Place


class OperationReader:
    """Reads all operations of one recipe into its draft."""

    def __init__(self, draft: RecipeDraft, cell: Cell, types: ActionTypes, report: Report) -> None:
        self._draft = draft
        self._report = report
        self._components = [
            component for component in cell.components.values() if component.capabilities
        ]
        self._types = {
            component.name: types.action(component.type) for component in self._components
        }
        self._prepared = {
            component.prepare.id: component.name
            for component in cell.components.values()
            if component.prepare
        }
        self._listed: dict[str, _Listed] = {}
        """By id; those without one of their own by a name that no id can be."""
        self._repeats: list[_Repeated] = []
        self._last: str | None = None
        self._is_full = False

    def read(self) -> None:
        """Read the operations, then what each is after."""
        fields = self._draft.fields
        nodes = fields.items('operations')
        if not nodes and fields.has('operations') and fields.is_sure('operations'):
            what = 'the recipe has no operations'
            self._report.add(fields.place('operations'), what, 'give at least one')
        for node in nodes:
            self._read(node)
        if not fields.is_sure('operations'):
            self._draft.note_unread_words(fields.unread_words('operations'))
        after = {entry.id: self._after(entry) for entry in self._listed.values()}
        before = _before(after)
        self._check_circles(after)
        for number, entry in enumerate(self._listed.values()):
            self._add(entry, number, after[entry.id], before[entry.id])
        drafts = {operation.id: operation for operation in self._draft.operations}
        for members, times, place in self._repeats:
            tasks = tuple(drafts[member] for member in members)
            self._draft.repeats.append(RepeatDraft(tasks, times, place))

    # --- the list ---------------------------------------------------------------------------

    def _read(self, node: Node) -> None:
        if not _is_repeat(node):
            self._operation(node)
            return
        fields = fields_of(node, REWORK, self._report)
        items = fields.items('repeat') if fields else ()
        if fields is None or not fields.is_sure('repeat'):
            self._draft.note_unread(node)
            return
        if not items:
            what = 'this repeat has no operations'
            self._report.add(fields.place('repeat'), what, 'give it one, or remove it')
        read = [self._member(item, number > 0) for number, item in enumerate(items)]
        members = [member for member in read if member is not None]
        self._repeats.append(_Repeated(members, fields.whole('times'), fields.node.place))

    def _member(self, node: Node, is_member: bool) -> str | None:
        if _is_repeat(node):
            what = 'a repeat cannot stand in a repeat'
            self._report.add(node.place, what, 'put its operations into one of them')
            self._draft.note_unread(node)
            return None
        return self._operation(node, is_member)

    def _operation(self, node: Node, is_member: bool = False) -> str | None:
        """Read an operation; returns its id."""
        fields = fields_of(node, OPERATION, self._report)
        if fields is None or not self._has_room(node):
            self._draft.note_unread(node)
            return None
        written = read_id(fields)
        if written is None or not fields.is_sure('id'):
            self._draft.note_unread_id(fields.unread_words('id'))
        nameless = f'{_NAMELESS}{len(self._listed)}'
        id_ = written or nameless
        if id_ in self._listed:
            line = self._listed[id_].fields.place('id').line
            what = f'two operations are called `{id_}` (line {line})'
            self._report.add(fields.place('id'), what, 'rename one of them')
            id_ = nameless
        elif id_ in self._prepared:
            what = f'`{id_}` is the preparation of `{self._prepared[id_]}` in the cell file'
            self._report.add(fields.place('id'), what, 'rename the operation')
        self._listed[id_] = _Listed(id_, fields, self._last, is_member)
        self._last = id_
        return id_

    def _has_room(self, node: Node) -> bool:
        """Tell whether one more operation is allowed; the first that is not is reported."""
        if len(self._listed) < OPERATIONS:
            return True
        if not self._is_full:
            what = f'the recipe has more than {OPERATIONS} operations'
            self._report.add(node.place, what, 'make two recipes of it')
        self._is_full = True
        return False

    # --- the order --------------------------------------------------------------------------

    def _after(self, entry: _Listed) -> tuple[str, ...]:
        """Return the operations directly before; without a word about it the one above."""
        names = entry.fields.names('after')
        above = [entry.above] if entry.above else []
        if not entry.fields.has('after') or not entry.fields.is_sure('after'):
            return tuple(above)
        known = above if entry.is_member else []
        for name in names:
            if name.text in self._listed:
                known.append(name.text)
            elif not self._draft.may_have(name.text):
                what = f'`after: [{name.text}]` names no operation'
                ids = [id_ for id_ in self._listed if not id_.startswith(_NAMELESS)]
                hint = did_you_mean(name.text, ids, f'the operations are {listing(ids)}')
                self._report.add(name.place, what, hint)
        return tuple(dict.fromkeys(known))

    def _check_circles(self, after: Mapping[str, Sequence[str]]) -> None:
        edges = [
            (upstream, downstream)
            for downstream, all_before in after.items()
            for upstream in all_before
        ]
        for circle in circles(edges):
            waiters = [
                operation
                for operation in circle[1:]
                if self._listed[operation].fields.has('after')
            ]
            place = self._listed[waiters[-1]].fields.place('after')
            what = f'operations wait for each other: {", ".join(circle)}'
            self._report.add(place, what, 'let one of them come first')

    # --- who does it ------------------------------------------------------------------------

    def _add(
        self, entry: _Listed, number: int, after: tuple[str, ...], before: frozenset[str]
    ) -> None:
        does = entry.fields.names('do')
        if not does and entry.fields.has('do') and entry.fields.is_sure('do'):
            self._report.add(
                entry.fields.place('do'), '`do` is empty', OPERATION.by_name['do'].hint
            )
        candidates = tuple(c for name in does for c in self._candidates(name))
        names = tuple(name.text for name in does)
        options = {**_agreed(candidates), **written_options(entry.fields)}
        draft = OperationDraft(
            Task(entry.id, '', '', '', **options),
            entry.fields,
            Position(1, 0, 0, number),
            None,
            given_by_all(candidates, names),
            candidates=candidates,
            does=names,
            before=before,
            after=after,
        )
        self._draft.operations.append(draft)
        if not entry.id.startswith(_NAMELESS):
            self._draft.by_id[entry.id] = draft

    def _candidates(self, name: Scalar) -> Iterator[Candidate]:
        is_known = False
        for component in self._components:
            capability = component.capabilities.get(name.text)
            if capability is not None:
                is_known = True
                yield Candidate(component.name, self._types[component.name], capability)
        if not is_known:
            known = sorted({key for c in self._components for key in c.capabilities})
            otherwise = f'the cell has {listing(known)}' if known else 'the cell has none at all'
            what = f'no component has the capability {quoted(name.text)}'
            self._report.add(name.place, what, did_you_mean(name.text, known, otherwise))


def _before(after: Mapping[str, Sequence[str]]) -> dict[str, frozenset[str]]:
    """Return for each operation all that have ended before it starts."""
    return {operation: frozenset(_ahead(operation, after)) for operation in after}


def _ahead(start: str, after: Mapping[str, Sequence[str]]) -> set[str]:
    operations: set[str] = set()
    ahead = [*after[start]]
    while ahead:
        operation = ahead.pop()
        if operation not in operations:
            operations.add(operation)
            ahead += after[operation]
    return operations


def _agreed(candidates: Sequence[Candidate]) -> dict[str, object]:
    """Return the options that hold whoever does it."""
    if not candidates:
        return {}
    first, *others = (candidate.capability.options for candidate in candidates)
    return {
        name: value
        for name, value in first.items()
        if all(other.get(name) == value for other in others)
    }


def _is_repeat(node: Node) -> bool:
    """Tell whether a repeat is meant, even if the word is misspelt."""
    if not isinstance(node, MapNode) or node.find('do'):
        return isinstance(node, MapNode) and node.find('repeat') is not None
    return any(nearest(entry.key.text, ('repeat',), 0.75) for entry in node.entries)
