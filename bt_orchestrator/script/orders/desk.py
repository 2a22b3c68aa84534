"""Orders are read, bound to their scripts and proven here, in another process than the line.

Questions and answers pass between two processes, so both are plain frozen data.
"""

from __future__ import annotations

import hashlib
import pickle
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import Sharing
from bt_orchestrator.model.jobs.order import NO_TERMS, Job, RecipeChoice, Terms, WorkOrder
from bt_orchestrator.model.proof.sharing import examine
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes, MadeScript
from bt_orchestrator.script.lookup import find_below, find_script
from bt_orchestrator.script.orders.admission import admitted
from bt_orchestrator.script.orders.order_file import (
    OrderPlaces,
    bind_order,
    named_places,
    params_from_text,
    parse_draft,
)
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.orders.terms import (
    NOT_MADE_HERE,
    NOTHING_SAID,
    AskedTerms,
    Wrong,
    wrong_choice,
)
from bt_orchestrator.script.source_text import read_text

ANY_PATH = '--script-paths'
"""The option of the node that allows paths outside its folders."""

SCRIPTS_KEPT = 32
"""Scripts, good and bad, that need not be read again while their text stays the same."""


@dataclass(frozen=True)
class AskedOrder:
    """A work order as texts, as a client names it."""

    script: str = ''
    order: str = ''
    quantity: int = 0
    params: Mapping[str, str] = field(default_factory=dict)
    """Written as in YAML."""
    terms: AskedTerms = NOTHING_SAID
    recipe: RecipeChoice | None = None
    """None: it names a script."""
    text: str = ''
    """The whole order as the text of a file; empty: the other fields say it."""

    @property
    def keeps_script(self) -> bool:
        """Tell whether a change names neither a script nor anything of a recipe."""
        return not self.script and self.recipe is None


@dataclass(frozen=True)
class Orders:
    """Make a job of each of these."""

    orders: tuple[AskedOrder, ...]
    made: MadeScripts = ()

    @property
    def named(self) -> Iterator[str]:
        """Ids that are given; empty where one is to be assigned."""
        return (order.order for order in self.orders)


@dataclass(frozen=True)
class WrittenOrder:
    """Make a job of a work order as it stands in a file."""

    text: str
    made: MadeScripts = ()

    @property
    def named(self) -> Iterator[str]:
        """Unknown before the file is read."""
        return iter(('',))


@dataclass(frozen=True)
class ChangedJob:
    """Change a queued job as requested; everything else stays.

    Parameters that a new script does not have are gone.
    """

    job: str
    script: str
    """Digest of the one that it has now."""
    quantity: int
    params: Mapping[str, object]
    wish: AskedOrder
    terms: Terms = NO_TERMS
    recipe: RecipeChoice | None = None
    """Its source; it stays as long as its script does."""
    made: MadeScripts = ()

    @property
    def choice(self) -> RecipeChoice | None:
        """The recipe for it; None: no recipe."""
        wish = self.wish
        if wish.script or wish.recipe is None:
            return wish.recipe
        return wish.recipe.over(self.recipe)

    @property
    def named(self) -> Iterator[str]:
        """It keeps its id."""
        return iter((self.job,))


class NotMadeYet(Refused):
    """An order by recipe cannot be read before its script is made."""

    def __init__(self, findings: Sequence[Finding], choice: RecipeChoice) -> None:
        """Name the scripts to make; where none can be made, the findings say why."""
        super().__init__(findings)
        self.choice = choice

    def __reduce__(self) -> tuple[Any, Any]:
        return type(self), (self.findings, self.choice)


Wanted = Orders | WrittenOrder | ChangedJob

MadeScripts = tuple[tuple[RecipeChoice, MadeScript | Refused], ...]
"""The generated scripts, by the choices of orders: a file that is changed meanwhile needs another
script."""


@dataclass(frozen=True)
class Question:
    """A request, with the data of the line that it needs."""

    wanted: Wanted
    free_ids: tuple[str, ...] = ()
    """For orders without one."""
    live: tuple[str, ...] = ()
    """Digests of the scripts of live jobs that have flags."""
    scripts: Mapping[str, bytes] = field(default_factory=dict)
    """Those and the one of a job to be changed, pickled, by digest."""
    held: frozenset[str] = frozenset()
    """Names of scripts that the client process has; they are not sent again."""


@dataclass(frozen=True)
class Reading:
    """The result for each order, and whether their scripts can share the line."""

    read: tuple[Job | Refused, ...]
    sharing: Sharing

    @property
    def choices(self) -> tuple[RecipeChoice | None, ...]:
        """Of each order, the recipe that has to be made into a script before it can be read."""
        return tuple(
            result.choice if isinstance(result, NotMadeYet) else None for result in self.read
        )


class OrderDesk:
    """Makes jobs of orders for one cell."""

    def __init__(
        self, cell: Cell, types: ActionTypes, trees: Sequence[Path], *, any_path: bool
    ) -> None:
        """Read scripts for clients.

        :param trees: folders in which scripts are looked up
        :param any_path: whether a client may also name a script elsewhere by its path; any
            participant of the ROS 2 domain is a client
        """
        self._cell = cell
        self._types = types
        self._types_by_component = action_types(cell, types)
        self._trees = trees
        self._find = find_script if any_path else partial(find_below, option=ANY_PATH)
        self._read: OrderedDict[tuple[Path, bytes], Script | Refused] = OrderedDict()
        self._sent: dict[str, Script] = {}

    def answer(self, question: Question) -> Reading:
        """Read what is wanted."""
        self._take_in(question.scripts)
        read = tuple(self._jobs(question.wanted, iter(question.free_ids)))
        new = {digest(job.script): job.script for job in read if isinstance(job, Job)}
        live = {name: self._sent[name] for name in question.live}
        return Reading(read, examine(new, live))

    def _take_in(self, scripts: Mapping[str, bytes]) -> None:
        """Know the scripts that are live now, and no others."""
        self._sent = {
            name: self._sent.get(name) or pickle.loads(data) for name, data in scripts.items()
        }

    def _jobs(self, wanted: Wanted, ids: Iterator[str]) -> Iterator[Job | Refused]:
        match wanted:
            case Orders(orders):
                scripts = _Scripts(self)
                for order in orders:
                    if order.text:
                        yield self._written(order.text, wanted.made, ids)
                        continue
                    yield self._asked(order, wanted.made, scripts, ids)
            case WrittenOrder(text, made):
                yield self._written(text, made, ids)
            case ChangedJob():
                yield self._changed(wanted)

    def _asked(
        self, order: AskedOrder, made: MadeScripts, scripts: _Scripts, ids: Iterator[str]
    ) -> Job | Refused:
        name, recipe = order.order or next(ids), order.recipe
        script = self._script_of(order, made, named_places(name), scripts.named)
        if isinstance(script, Refused):
            return script
        params = params_from_text(order.params, script)
        quantity = order.quantity or None
        wanted = WorkOrder(order.script, order.order or None, quantity, params, recipe=recipe)
        terms = order.terms.over(NO_TERMS)
        return self._bound(wanted, script, name, terms, self._cell.most_items)

    def _written(self, text: str, made: MadeScripts, ids: Iterator[str]) -> Job | Refused:
        try:
            draft = parse_draft(text, 'order')
        except Refused as refused:
            return refused
        order, places = draft.order, draft.places
        if not all(places.is_sure(key) for key in ('script', 'recipe', 'version', 'bind')):
            return Refused(places.findings)
        script = self._script_of(order, made, places, self.script)
        if isinstance(script, Refused):
            return Refused([*places.findings, *script.findings]) if places.findings else script
        try:
            name = order.order or next(ids)
            types, most = self._types_by_component, self._cell.most_items
            return bind_order(order, script, name, places, types, most)
        except Refused as refused:
            return refused

    def _changed(self, wanted: ChangedJob) -> Job | Refused:
        wish = replace(wanted.wish, recipe=wanted.choice)
        script: Script | Refused = self._sent[wanted.script]
        if not wish.keeps_script:
            places = named_places(wanted.job)
            script = self._script_of(wish, wanted.made, places, self.script)
        if isinstance(script, Refused):
            return script
        kept = {key: value for key, value in wanted.params.items() if key in script.params}
        given = params_from_text(wish.params, script)
        quantity = wish.quantity or wanted.quantity
        recipe = wanted.recipe if wish.keeps_script else wish.recipe
        params = {**kept, **given}
        # Its id and its quantity may be of before they were limited.
        order = WorkOrder(script.name, None, quantity, params, recipe=recipe)
        most = max(wanted.quantity, self._cell.most_items)
        return self._bound(order, script, wanted.job, wish.terms.over(wanted.terms), most)

    def _script_of(
        self,
        order: AskedOrder | WorkOrder,
        scripts: MadeScripts,
        places: OrderPlaces,
        named: Callable[[str], Script | Refused],
    ) -> Script | Refused:
        """Return the script that an order names, or that was generated for it."""
        wrong = wrong_choice(order.script, order.recipe)
        if wrong is not None:
            return Refused([places.finding(wrong)])
        if order.recipe is None:
            script = named(order.script)
            return _in_order(script, places) if isinstance(script, Refused) else script
        made = next((made for choice, made in scripts if choice == order.recipe), None)
        if made is None:
            return NotMadeYet([places.finding(NOT_MADE_HERE)], order.recipe)
        if isinstance(made, Refused):
            return made
        return self.made(made)

    def _bound(
        self, order: WorkOrder, script: Script, name: str, terms: Terms | Wrong, most_items: int
    ) -> Job | Refused:
        places = named_places(name)
        if isinstance(terms, Wrong):
            places = replace(places, findings=(places.finding(terms),))
        else:
            order = replace(order, terms=terms)
        try:
            types = self._types_by_component
            return bind_order(order, script, name, places, types, most_items)
        except Refused as refused:
            return refused

    def script(self, name: str) -> Script | Refused:
        """Read and prove a script, unless its text is one that was read before."""
        try:
            path = self._find(name, self._trees)
            text = read_text(path)
        except Refused as refused:
            return refused
        return self._known(path, text)

    def made(self, made: MadeScript) -> Script | Refused:
        """Read and prove a script that was generated."""
        return self._known(Path(made.name), made.text)

    def _known(self, path: Path, text: str) -> Script | Refused:
        key = (path, hashlib.sha256(text.encode()).digest())
        if key not in self._read:
            self._read[key] = self._admitted(text, path)
        self._read.move_to_end(key)
        if len(self._read) > SCRIPTS_KEPT:
            self._read.popitem(last=False)
        return self._read[key]

    def _admitted(self, text: str, path: Path) -> Script | Refused:
        try:
            return admitted(text, str(path), self._cell, self._types)
        except Refused as refused:
            return refused


def _in_order(refused: Refused, places: OrderPlaces) -> Refused:
    """Return mistakes, with those in a key of the order where it stands."""
    return Refused(
        [
            places.finding(Wrong(finding.key, finding.what, finding.hint))
            if finding.key
            else finding
            for finding in refused.findings
        ]
    )


class _Scripts:
    """The scripts of one request: each is looked for once, however many orders name it."""

    def __init__(self, desk: OrderDesk) -> None:
        self._desk = desk
        self._by_name: dict[str, Script | Refused] = {}

    def named(self, name: str) -> Script | Refused:
        if name not in self._by_name:
            self._by_name[name] = self._desk.script(name)
        return self._by_name[name]
