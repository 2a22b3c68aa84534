"""Recipes in folders: found by name and version, with what they declare for their orders."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import Capability
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.declared import read_parameters
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.fields import file_fields
from bt_orchestrator.script.lookup import scripts_in
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, DeclaredVersion
from bt_orchestrator.script.orders.order_file import OrderPlaces
from bt_orchestrator.script.orders.recipe_keys import RECIPE
from bt_orchestrator.script.orders.terms import Wrong
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.source_text import ReadOnce, read_text
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar, quoted


class Candidate(NamedTuple):
    """A component that can do an operation."""

    component: str
    type: ActionType
    capability: Capability

    def __str__(self) -> str:
        return f'`{self.capability.name}` at `{self.component}`'

    def goal_field(self, name: str) -> FieldType:
        """Return the type of a field that the capability names."""
        return self.type.goal.fields[name]

    @property
    def given(self) -> Mapping[str, FieldType]:
        """Types of what it tells later operations."""
        fields = self.type.result.fields
        return {name: fields[field] for name, field in self.capability.gives.items()}


@dataclass(frozen=True)
class OperationDraft(TaskDraft):
    """One operation as far as it could be read.

    As a task it has those options that hold wherever it is done, and as its action's type what all
    candidates tell: it is not yet known which of them will do it.
    """

    does: tuple[str, ...] = ()
    """Capabilities, as written."""
    candidates: tuple[Candidate, ...] = ()
    """Empty: none is known, or `do` could not be read."""
    before: frozenset[str] = frozenset()
    """Ids of all operations that have ended before it starts."""
    after: tuple[str, ...] = ()
    """Ids of those directly before it."""

    @property
    def identifies(self) -> bool:
        """Tell whether its result may have the serial: it says so, or one that can do it does."""
        able = (candidate.capability.options for candidate in self.candidates)
        return super().identifies or any('identifies' in options for options in able)

    def precedes(self, other: TaskDraft) -> bool:
        """Tell whether it has ended before the other one starts."""
        return isinstance(other, OperationDraft) and self.id in other.before

    def may_precede(self, other: TaskDraft) -> bool:
        """Tell whether it has ended before the other one starts."""
        return self.precedes(other)

    def hint_to_precede(self, other: TaskDraft) -> str:
        """Say what to write at an operation beside it; empty: it is not beside it."""
        if not isinstance(other, OperationDraft) or not self.is_beside(other):
            return ''
        before = ', '.join((*other.after, self.id))
        return f'write `after: [{before}]` there'

    def is_beside(self, other: TaskDraft) -> bool:
        """Tell whether neither of two operations is before the other."""
        return other is not self and not self.precedes(other) and not other.precedes(self)


@dataclass
class RecipeDraft(ScriptDraft):
    """A recipe as far as it could be read."""

    kind: str = 'recipe'
    a_step: str = 'an operation'
    operations: list[OperationDraft] = field(default_factory=list)


def given_by_all(candidates: Sequence[Candidate], does: Sequence[str]) -> ActionType | None:
    """Return what every candidate tells, as the type of an action; None if there is none."""
    if not candidates:
        return None
    first, *others = (candidate.given for candidate in candidates)
    fields = {name: type_ for name, type_ in first.items() if all(name in o for o in others)}
    name = ' or '.join(f'`{capability}`' for capability in does)
    return ActionType(name, MessageType(name, {}), MessageType(name, fields))


OVERRIDES = '.overrides'
"""The overrides of WM-100.yaml are in WM-100.overrides.yaml beside it."""


class Shelved(NamedTuple):
    """The file of a recipe."""

    name: str
    version: int
    path: Path

    @property
    def overrides(self) -> Path | None:
        """The decisions of an engineer about it; None: no decision."""
        path = self.path.with_name(f'{self.path.stem}{OVERRIDES}{self.path.suffix}')
        return path if path.is_file() else None


def shelved(folders: Sequence[Path]) -> Iterator[Shelved]:
    """Yield the recipes in some folders; files that are none, or cannot be read, are left out."""
    for folder in folders:
        for path in scripts_in(folder):
            file = shelved_at(path)
            if file is not None:
                yield file


def find_recipe(
    name: str, choice: RecipeChoice, folders: Sequence[Path], places: OrderPlaces
) -> Shelved:
    """Return the file of one of the recipes that an order names.

    Of a version that is in several folders, the first folder has it.

    :param places: of the order
    :raises Refused: there is none, or not of that version, or two in one folder
    """
    known = list(shelved(folders))
    versions: dict[int, Shelved] = {}
    for file in known:
        if file.name == name and versions.setdefault(file.version, file) is not file:
            _refuse_twins(versions[file.version], file, places)
    wanted = max(versions, default=None) if choice.version is None else choice.version
    if wanted in versions:
        return versions[wanted]
    raise Refused([places.finding(_missing(name, choice, versions, known, folders))])


def _missing(
    name: str,
    choice: RecipeChoice,
    versions: dict[int, Shelved],
    known: Sequence[Shelved],
    folders: Sequence[Path],
) -> Wrong:
    if versions:
        there = ', '.join(map(str, sorted(versions)))
        is_one = 'there is' if len(versions) == 1 else 'there are'
        what = f'recipe {name} has no version {choice.version}; {is_one} {there}'
        return Wrong('version', what, 'leave `version` out for the newest')
    names = list(dict.fromkeys(file.name for file in known))
    looked = ', '.join(map(str, folders)) or 'no folder'
    what = f'there is no recipe {quoted(name)}: looked in {looked}'
    others = f'the recipes are {listing(names)}' if names else 'there are none; see --recipes'
    return Wrong('recipe', what, did_you_mean(name, names, others))


def _refuse_twins(first: Shelved, second: Shelved, places: OrderPlaces) -> None:
    if first.path.parent != second.path.parent:
        return
    files = f'{first.path} and {second.path.name}'
    what = f'recipe {first.name} has version {first.version} twice: {files}'
    raise Refused([places.finding(Wrong('recipe', what, 'give one of them another version'))])


def shelved_at(path: Path) -> Shelved | None:
    """Return the recipe of a file; None: the file is no recipe, or cannot be read."""
    if path.stem.endswith(OVERRIDES):
        return None
    try:
        root = compose(read_text(path), Report(str(path)))
    except Refused:
        return None
    if not isinstance(root, MapNode) or root.find('operations') is None:
        return None
    name, version = (_plain(root, key) for key in ('recipe', 'version'))
    if isinstance(name, Scalar) and isinstance(version, Scalar) and type(version.value) is int:
        return Shelved(name.text, version.value, path)
    return None


def _plain(root: MapNode, key: str) -> object:
    entry = root.find(key)
    return entry.value if entry else None


# The declarations of recipes for their orders: read without a cell, and without planning.


class DeclaredRecipes:
    """The recipes in some folders; an unchanged file is read once."""

    def __init__(self, folders: Sequence[Path]) -> None:
        """Prepare; nothing is read."""
        self._folders = tuple(folders)
        self._files = ReadOnce(declared_version)

    def read(self) -> list[DeclaredRecipe]:
        """Return those that orders can name, by name."""
        files = chain.from_iterable(map(scripts_in, self._folders))
        return list(recipes_of(self._files.of(files)))


def declared_version(path: Path) -> DeclaredVersion:
    """Read what a file declares.

    :raises Refused: it is no recipe
    """
    file = shelved_at(path)
    if file is None:
        hint = 'a recipe begins with `recipe: NAME`'
        raise Refused([Finding(str(path), 1, 1, 'this is no recipe', hint)])
    report = Report(str(path))
    try:
        draft = RecipeDraft(file_fields(read_text(path), RECIPE, report))
        read_parameters(draft, report)
        report.refuse()
    except Refused:
        return DeclaredVersion(file.name, file.version, {}, {}, has_mistakes=True)
    operations = dict(_operations(draft.fields.node, 'operations'))
    return DeclaredVersion(file.name, file.version, draft.params, operations)


def recipes_of(declared: Iterable[DeclaredVersion]) -> Iterator[DeclaredRecipe]:
    """Yield recipes by name; of a version that is there twice the first counts.

    One whose newest version has mistakes is left out: an order of it would be refused.
    """
    by_name: dict[str, dict[int, DeclaredVersion]] = {}
    for recipe in declared:
        by_name.setdefault(recipe.name, {}).setdefault(recipe.version, recipe)
    for name, versions in sorted(by_name.items()):
        if not versions[max(versions)].has_mistakes:
            sound = [recipe for _, recipe in sorted(versions.items()) if not recipe.has_mistakes]
            yield DeclaredRecipe(name, tuple(sound))


def _operations(node: MapNode, key: str) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield operations with what they do; an order of one with mistakes tells them."""
    for member in _listed(node, key):
        if isinstance(member, MapNode):
            yield from _operations(member, 'repeat')
            ids, does = (tuple(_texts(member, key)) for key in ('id', 'do'))
            if ids and does:
                yield ids[0], does


def _texts(node: MapNode, key: str) -> Iterator[str]:
    return (
        scalar.text for scalar in _listed(node, key) if isinstance(scalar, Scalar) and scalar.text
    )


def _listed(node: MapNode, key: str) -> Sequence[Node]:
    """Return the members of a list, or what stands for it."""
    entry = node.find(key)
    if entry is None:
        return ()
    return entry.value.items if isinstance(entry.value, ListNode) else (entry.value,)
