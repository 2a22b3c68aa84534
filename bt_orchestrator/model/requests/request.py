"""What a request is: its arguments, who may make it, and when it needs a reason."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bt_orchestrator.model.roles import Role


class About(Enum):
    """What a request is about; all but a cell are named by an id, the first argument."""

    CELL = 'cell'
    QUEUE = 'queue'
    JOB = 'job'
    ITEM = 'item'
    HOLD = 'hold'


class Kind(Enum):
    """What the value of a parameter is."""

    TEXT = 'text'
    WHOLE = 'whole number'
    YES_NO = 'yes or no'
    TEXTS = 'texts'
    VALUES = 'values by name'
    ORDERS = 'work orders'


class Why(Enum):
    """When somebody has to say why."""

    FIRST = 'first'
    """The request is refused without a reason."""
    AFTERWARDS = 'afterwards'
    """Danger does not wait: it is carried out, and a surface asks for the reason then."""
    NEVER = 'never'
    """A reason is kept if one is given."""


@dataclass(frozen=True)
class Parameter:
    """One argument of a request."""

    name: str
    kind: Kind
    meaning: str
    is_required: bool = False
    choices: tuple[str, ...] = ()
    """The only values of a text; empty: any."""
    roles: frozenset[Role] | None = None
    """Who may give it; None: whoever may make the request."""


@dataclass(frozen=True)
class Request:
    """One thing that can be asked."""

    word: str
    """As people type it and as it is recorded, for instance abort_job."""
    about: About
    effect: str
    """What it does, for somebody who is about to ask it."""
    roles: frozenset[Role]
    parameters: tuple[Parameter, ...] = ()
    why: Why = Why.FIRST
    is_confirmed: bool = False
    """It changes items, queue or belt in a way that cannot be taken back: a surface asks twice."""
    also: tuple[str, ...] = ()
    """Other words for it that commands take; recorded is `word`."""

    @property
    def name(self) -> str:
        """Name that no other request has, for instance job.pause."""
        return f'{self.about.value}.{self.word}'

    @property
    def subject(self) -> Parameter | None:
        """The id of what it is about; None: of the cell there is only one."""
        return self.parameters[0] if self.about in NAMED else None


NAMED = {
    About.JOB: Parameter('job', Kind.TEXT, 'id of the job', is_required=True),
    About.ITEM: Parameter('item', Kind.TEXT, 'for example WO-1001/3', is_required=True),
    About.HOLD: Parameter('hold', Kind.TEXT, 'id of the hold', is_required=True),
}
"""The first argument of what is about one of many."""
