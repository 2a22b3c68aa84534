"""The declarations of scripts for their orders, read without a cell; what an order can choose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.model.cell import HoldAfter
from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.drafts import ScriptDraft
from bt_orchestrator.script.field_types import PARAMETER_TYPES, misfit
from bt_orchestrator.script.fields import Fields, fields_of, file_fields
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.orders.by_recipe import DeclaredRecipe, recipes
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_keys import PARAMETER, SCRIPT
from bt_orchestrator.script.source_text import ENDINGS, ReadOnce, read_text
from bt_orchestrator.script.yaml_nodes import Entry, Scalar, found, words


@dataclass(frozen=True)
class Declared:
    """The head of a script."""

    name: str
    """By which an order names it: that of its file, without its ending."""
    params: Mapping[str, Parameter]
    quantity: int | None
    """Default for orders that name none."""


def declared(path: Path) -> Declared:
    """Read the head of a script.

    :raises Refused: it is no script, or there is a mistake in what is read
    """
    report = Report(str(path))
    fields = file_fields(read_text(path), SCRIPT, report)
    draft = ScriptDraft(fields)
    read_parameters(draft, report)
    quantity = fields.optional_whole('quantity')
    report.refuse()
    return Declared(path.stem, draft.params, quantity)


def script_files(folders: Sequence[Path]) -> Iterator[Path]:
    """Yield the files in which a script is looked up by name: the first of each name."""
    names: set[str] = set()
    for folder in folders:
        for path in sorted(_files(folder)):
            if path.stem not in names:
                names.add(path.stem)
                yield path


def _files(folder: Path) -> Iterator[Path]:
    try:
        yield from (path for path in folder.iterdir() if path.suffix == ENDINGS[0])
    except OSError:
        return


# The choices of orders, as far as there are files here: scripts and recipes.


class OrderFiles:
    """The folders of a node; an unchanged file is read once.

    What cannot be read is left out, and an order of it tells why.
    """

    def __init__(self, trees: Sequence[Path] = (), folders: Sequence[Path] = ()) -> None:
        """Prepare; nothing is read.

        :param trees: folders of scripts
        :param folders: of recipes
        """
        self._trees = tuple(trees)
        self._of_scripts = ReadOnce(declared)
        has_recipes = folders and not RECIPES.missing
        self._of_recipes = recipes().orderable(folders) if has_recipes else list

    def scripts(self) -> list[Declared]:
        """Return the scripts that orders can name: the first of each name."""
        return self._of_scripts.of(script_files(self._trees))

    def recipes(self) -> list[DeclaredRecipe]:
        """Return the recipes that orders can name, by name."""
        return self._of_recipes()


# The limit of rejects that a script, a recipe or a cell file declares.


def read_hold_after(file: Fields) -> HoldAfter | None:
    """Return how many rejects among how many items hold the line (semantics 7.7)."""
    fields = file.table('hold_after')
    if fields is None:
        return None
    limit = HoldAfter(fields.whole('rejects'), fields.whole('of'))
    if fields.is_sure('rejects', 'of') and limit.rejects > limit.of:
        what = f'there are never {limit.rejects} rejects among {limit.of} items'
        fields.refuse('rejects', what, f'write at most {limit.of}, or a larger `of`')
    return limit


# The parameters that a script declares.


def read_parameters(draft: ScriptDraft, report: Report) -> None:
    """Read `params` into the draft."""
    node = draft.fields.mapping('params')
    if node is None:
        draft.unread_params.update(draft.fields.unread_words('params'))
        return
    for entry in node.entries:
        name = entry.key.text
        check_name(name, 'parameter name', entry.key.place, report)
        parameter = _parameter(entry, report)
        is_sure = name not in node.doubtful
        draft.params[name] = parameter if is_sure else replace(parameter, type='', default=None)
    for entry in node.repeated:
        _parameter(entry, report)
    for value in node.lost:
        draft.unread_params.update(words(value))


def _parameter(entry: Entry, report: Report) -> Parameter:
    fields = fields_of(entry.value, PARAMETER, report)
    if fields is None:
        return Parameter(entry.key.text, type='')
    type_name = fields.choice('type')
    default = _default(fields, type_name or '', report)
    return Parameter(entry.key.text, type_name or '', default, not fields.has('default'))


def _default(fields: Fields, type_name: str, report: Report) -> Any:
    node = fields.value('default')
    if node is None or type_name not in PARAMETER_TYPES:
        return None
    value: Any = node.value if isinstance(node, Scalar) else node
    problem = misfit(value, PARAMETER_TYPES[type_name])
    if problem is not None:
        what = f'`default` must be {problem.needed}, not {found(node)}'
        report.add(node.place, what, problem.hint)
        return None
    return float(value) if type_name == 'float' else value
