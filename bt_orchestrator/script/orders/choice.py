"""The choice of an order in place of a script: recipes, a version, and bindings."""

from __future__ import annotations

from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.orders.terms import Wrong
from bt_orchestrator.script.yaml_nodes import Scalar, found

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
