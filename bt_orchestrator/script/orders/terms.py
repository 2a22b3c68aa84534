"""Terms of an order, checked alike at every door, and its choice in place of a script."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.order import RecipeChoice, Terms
from bt_orchestrator.model.limits import DETAILS_BYTES, DETAILS_DEPTH
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.field_types import Misfit
from bt_orchestrator.script.fields import Fields, broken_limit
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.orders.instants import instant, out_of_range
from bt_orchestrator.script.script_keys import ORDER
from bt_orchestrator.script.yaml_nodes import Scalar, as_data, found, found_value, quoted

LARGEST_NUMBER = 2**63 - 1
"""Whole numbers in details; other programs read no larger ones."""


class Wrong(NamedTuple):
    """A mistake in one of the keys."""

    key: str
    """For instance `due`, or `bind.insert`."""
    what: str
    hint: str


@dataclass(frozen=True)
class AskedTerms:
    """A client's priority, times and details; None and an empty text: not given."""

    priority: int | None = None
    start: float | None = None
    """0.0: none is wanted."""
    due: float | None = None
    """0.0: none is wanted."""
    details: str = ''
    """JSON."""
    first_piece: bool | None = None

    def over(self, terms: Terms) -> Terms | Wrong:
        """Return the job's new terms; values not given stay."""
        details = details_of(self.details) if self.details else terms.details
        if isinstance(details, Wrong):
            return details
        return Terms(
            terms.priority if self.priority is None else self.priority,
            terms.start if self.start is None else self.start or None,
            terms.due if self.due is None else self.due or None,
            details,
            terms.first_piece if self.first_piece is None else self.first_piece,
        )


NOTHING_SAID = AskedTerms()


def read_terms(fields: Fields) -> Terms:
    """Read the keys of an order file, and report every mistake in them."""
    details = fields.mapping('details')
    terms = Terms(
        fields.whole('priority'),
        _moment(fields, 'start'),
        _moment(fields, 'due'),
        as_data(details) if details else {},  # type: ignore[arg-type]  # it is a mapping
        fields.switch('first_piece'),
    )
    for wrong in wrong_terms(terms):
        if fields.is_sure(wrong.key):
            fields.refuse(*wrong)
    return terms


def details_of(text: str) -> Mapping[str, object] | Wrong:
    """Return details that came as JSON; an empty text: none."""
    try:
        value = json.loads(text or '{}')
    except (RecursionError, ValueError) as error:
        why = 'it is nested too deep' if isinstance(error, RecursionError) else str(error)
        return Wrong('details', f'`details` must be JSON: {why}', 'write for instance {"lot": 7}')
    if not isinstance(value, dict):
        what = f'`details` must be a JSON object, not {found_value(value)}'
        return Wrong('details', what, 'write for instance {"lot": 7}')
    return value


def wrong_terms(terms: Terms) -> Iterator[Wrong]:
    """Yield what is wrong, whichever way the order came."""
    limit = broken_limit(ORDER.by_name['priority'], terms.priority)
    if limit is not None:
        what = sentence('key', key='priority', needed=limit, given=found_value(terms.priority))
        yield Wrong('priority', what, sentence('priority_is'))
    moments = {'start': terms.start, 'due': terms.due}
    given = {key: time for key, time in moments.items() if time is not None}
    misfits = [key for key, time in given.items() if out_of_range(time)]
    for key in misfits:
        yield Wrong(key, sentence('years', key=key), sentence('years_why'))
    if len(given) == 2 and not misfits and given['due'] < given['start']:
        yield Wrong('due', sentence('due_first'), sentence('other_zone'))
    unfit = _unfit(terms.details)
    if unfit is not None:
        yield Wrong('details', f'`details` must have {unfit.needed}', unfit.hint)


def _moment(fields: Fields, key: str) -> float | None:
    text = fields.text(key)
    if text is None:
        return None
    time = instant(text)
    if isinstance(time, Misfit):
        fields.refuse(key, f'`{key}` must be {time.needed}, not {quoted(text)}', time.hint)
        return None
    return time


def _unfit(details: Mapping[str, object]) -> Misfit | None:
    """Say why details cannot be kept; None: they can."""
    for value, depth in _values(details, 1):
        if depth > DETAILS_DEPTH:
            needed = f'at most {DETAILS_DEPTH} lists and mappings within each other'
            return Misfit(needed, 'say it more plainly')
        if isinstance(value, float) and not math.isfinite(value):
            return Misfit('finite numbers', 'JSON has no others; write a text, or null')
        if isinstance(value, int) and abs(value) > LARGEST_NUMBER:
            return Misfit('whole numbers of at most 64 bits', 'write a longer one as a text')
    size = len(json_of(details).encode())
    if size > DETAILS_BYTES:
        needed = f'at most {DETAILS_BYTES} bytes as JSON, and not {size}'
        return Misfit(needed, 'keep the rest where the order comes from')
    return None


def _values(value: Any, depth: int) -> Iterator[tuple[Any, int]]:
    """Yield a value and all in it, with their depths; none below one that is too deep."""
    yield value, depth
    if depth > DETAILS_DEPTH:
        return
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, Sequence) and not isinstance(value, str):
        for member in value:
            yield from _values(member, depth + 1)


# The choice of an order in place of a script: recipes, a version, and bindings.

BOTH = 'the order names recipe and script'
NEITHER = 'a work order needs the key `script` or `recipe`'
NAME_ONE = 'write for instance `script: my_process`, or `recipe: WM-100`'
NOT_MADE_HERE = Wrong(
    'recipe',
    'no script can be made from a recipe here',
    'make it with `bt-orchestrator generate`, and name it with `script`',
)


def read_choice(fields: Fields) -> RecipeChoice | None:
    """Read the keys of an order, and report every mistake in them; None: it names a script."""
    names = fields.names('recipe')
    version = fields.optional_whole('version')
    bind = _bind(fields)
    if not fields.has('recipe'):
        _check_script(fields)
        return None
    if fields.has('script'):
        fields.refuse('recipe', BOTH, 'keep one')
    elif not names and fields.is_sure('recipe'):
        fields.refuse('recipe', '`recipe` names none', 'write for instance `recipe: WM-100`')
    for name in names:
        if not check_id(name.text, 'recipe name', name.place, fields.report):
            fields.doubt('recipe')
    return RecipeChoice(tuple(name.text for name in names), version, bind)


def wrong_choice(script: str, recipe: RecipeChoice | None) -> Wrong | None:
    """Say what is wrong with what an order names, whichever way it came; None: nothing is."""
    if recipe is None:
        return None if script else Wrong('script', NEITHER, NAME_ONE)
    if script and recipe.recipes:
        return Wrong('recipe', BOTH, 'keep one')
    if not recipe.recipes:
        key = 'bind' if recipe.version is None else 'version'
        return Wrong(key, *_of_recipe(key))
    return None


def _of_recipe(key: str) -> tuple[str, str]:
    what = f'`{key}` is about a recipe, and the order names none'
    return what, f'remove `{key}`, or name a recipe with `recipe`'


def _check_script(fields: Fields) -> None:
    """Report that an order names neither, and what only an order by recipe may have."""
    if not fields.has('script') and fields.is_sure('script', 'recipe'):
        fields.doubt('script')
        fields.report.add(fields.node.place, NEITHER, NAME_ONE)
        return
    for key in ('version', 'bind'):
        if fields.has(key):
            fields.refuse(key, *_of_recipe(key))


def _bind(fields: Fields) -> dict[str, str]:
    node = fields.mapping('bind')
    bind = {}
    for entry in node.entries if node else ():
        if isinstance(entry.value, Scalar) and entry.value.text:
            bind[entry.key.text] = entry.value.text
        else:
            fields.doubt('bind')
            what = f'`bind` must name a component, not {found(entry.value)}'
            hint = f'write for instance `{entry.key.text}: component_3a`'
            fields.report.add(entry.value.place, what, hint)
    return bind
