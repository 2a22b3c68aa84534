"""Files with a place for each of several mistakes, so that two can be made in one file.

A place is a few lines long, whatever is written there, so that nothing behind it moves. What is
written there comes from the tables of mistakes (`mistake_tables`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import combinations
from textwrap import indent
from typing import NamedTuple, cast

from fakes.mistake_tables import table
from fakes.mistake_texts import NAMED
from fakes.recipe_texts import HEAD

LINES = 6
"""Of each place."""


class Plant(NamedTuple):
    """One text of a table, at its place in a file."""

    name: str
    place: str
    text: str


Source = tuple[str, Callable[[str], 'str | None']]
"""A table, and what makes the lines of a place of one of its texts; None: it does not fit."""


class Frame(NamedTuple):
    """A file with places, and the texts of the tables that fit each of them."""

    text: str
    """With `<name>` on a line of its own for each place."""
    usual: Mapping[str, str]
    """What stands at each place if nothing is planted there."""
    sources: Mapping[str, tuple[Source, ...]]
    """By the name of the place."""

    def planted(self, *plants: Plant) -> str:
        """Return the file with these mistakes in it."""
        places = dict.fromkeys(self.sources, '')
        text = self.text
        planted = {plant.place: plant.text for plant in plants}
        for place, lines in {**places, **self.usual, **planted}.items():
            missing = LINES - max(1, len(lines.splitlines()))
            assert missing >= 0, lines
            text = text.replace(f'<{place}>\n', lines.rstrip('\n') + '\n' * (missing + 1))
        return text

    def plants(self) -> Iterator[Plant]:
        """Yield the mistakes of all tables."""
        for place, sources in self.sources.items():
            for name, wrap in sources:
                for case in table(name):
                    text, findings = cast(tuple[str, list[str]], case.values)
                    wrapped = wrap(text) if findings else None
                    if wrapped is not None:
                        yield Plant(f'{name}: {case.id}', place, wrapped)

    def pairs(self) -> Iterator[tuple[Plant, Plant]]:
        """Yield all pairs of mistakes at different places."""
        both = combinations(self.plants(), 2)
        return (pair for pair in both if pair[0].place != pair[1].place)


def _beginning(start: str, more: str = '') -> Callable[[str], str | None]:
    """Take texts that begin so, and put more behind their beginning."""
    return lambda text: start + more + text[len(start) :] if text.startswith(start) else None


def _behind(start: str, wanted: str) -> Callable[[str], str | None]:
    """Take what is behind the beginning of texts that go on as wanted."""
    return lambda text: text[len(start) :] if text.startswith(start + wanted) else None


def _section(text: str) -> str | None:
    """Take texts that are sections, but for those that the file has already."""
    lines = text.splitlines()
    is_section = all(line.startswith('  ') for line in lines)
    return text if is_section and not any(line[:4] in _TAKEN for line in lines) else None


_TAKEN = ('  1:', '  3:', '  4:')
_PARAMS = 'b: {type: bool}, n: {type: int}, s: {type: str}, x: {type: float}, lot: {type: str}, '
_INITIALIZATION = """\
{id: home, task: HOME, action: /belt/index},
  {id: ready, task: PREPARE, action: /loader/task},
  """
_SET = '{id: set, task: RUN, action: /lamp/task}'
RICH = '    - {{task: RUN, action: /lamp/task{}}}\n'
_USE = '    - {{id: use, task: TASK_A, action: /press/task, args: {{{}}}}}\n'

SCRIPT_FRAME = Frame(
    """\
script: test
<params>
<initialization>
sections:
  1: [{id: place, task: PLACE_AT_CONVEYOR, action: /loader/task, qty_change: 1}]
<section>
  3:
    - {id: look, task: RUN, action: /lamp/task}
<options>
<arguments>
<condition>
<references>
    - {id: press, task: TASK_A, action: /press/task}
  4: [{id: pack, task: PICK_AND_PACK, action: /packer/task, qty_change: -1}]
<flags>
<zones>
<order>
""",
    {
        'params': f'params: {{{_PARAMS}}}',
        'initialization': f'initialization: [{_INITIALIZATION}{_SET}]',
    },
    {
        'params': (('parameters', _beginning('params: {', _PARAMS)),),
        'initialization': (
            (
                'initialization_options',
                lambda text: f'initialization: [{_INITIALIZATION}{_SET[:-1]}, {text}}}]',
            ),
            (
                'groups',
                _beginning('initialization: [', f'{_INITIALIZATION}{_SET}, '),
            ),
        ),
        'section': tuple(
            (name, _section) for name in ('sections', 'groups', 'ids', 'section_rules')
        ),
        'options': (('task_options', RICH.format),),
        'arguments': (('arguments', lambda text: RICH.format(f', args: {{{text}}}')),),
        'condition': (('conditions', lambda text: RICH.format(f',\n      {text}')),),
        'references': (('references', _USE.format),),
        'flags': (('dependencies', _beginning('lateral_dependencies: [')),),
        'zones': (('dependencies', _beginning('zones: {')),),
        'order': (('dependencies', _beginning('initialization_dependencies: [')),),
    },
)

_BELT = 'conveyor: {{action: /belt/index, {}}}'

CELL_FRAME = Frame(
    """\
cell: c
<conveyor>
components:
  cart: {action: /cart/drive, type: nav_interfaces/action/DriveTo}
<names>
<options>
<abilities>
""",
    {
        'conveyor': _BELT.format('sections: 3, type: plain_interfaces/action/Index'),
    },
    {
        'conveyor': (
            ('conveyor', lambda text: _BELT.format(text) if 'sections: 3' in text else None),
        ),
        'names': (('component_names', '  arm: {{{}}}'.format),),
        'options': (
            (
                'component_options',
                lambda text: f'  leg: {{{NAMED}{text}}}'.replace('/arm/task', '/leg/task'),
            ),
        ),
        'abilities': (
            (
                'capabilities',
                lambda text: f'  able: {{{NAMED}{text}}}'.replace('arm', 'able'),
            ),
        ),
    },
)

_RECIPE_PARAMS = 'n: {type: int}, s: {type: str}, x: {type: float}, '

RECIPE_FRAME = Frame(
    f"""\
{HEAD}<params>
operations:
  - {{id: place, do: put}}
<operations>
  - {{id: pack, do: take}}
""",
    {'params': f'params: {{{_RECIPE_PARAMS}}}'},
    {
        'params': (('parameters', _beginning('params: {', _RECIPE_PARAMS)),),
        'operations': (('operations', lambda text: indent(text, '  ')),),
    },
)

ORDER_FRAME = Frame(
    """\
script: test
<order>
<quantity>
<params>
""",
    {'quantity': 'quantity: 2', 'params': 'params: {lot: A}'},
    {
        'order': (
            ('orders', _behind('script: a\n', 'order:')),
            ('orders', _behind('script: a\n', 'priority:')),
        ),
        'quantity': (('orders', _behind('script: a\n', 'quantity:')),),
        'params': (
            ('orders', _behind('script: a\n', 'params: {')),
            ('bindings', _behind('quantity: 2\n', 'params:')),
        ),
    },
)
