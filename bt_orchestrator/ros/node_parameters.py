"""The start parameters of a tree node.

One table: the node's ROS parameters, the options of `run`, and their page are made from it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.by import Control, Role
from bt_orchestrator.model.goal import SERVER_TIMEOUT_S
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place

SINGLE, EVENTS = 'single', 'events'
BUILTIN, PY_TREES_ROS = 'builtin', 'py_trees_ros'
AUTO, PLAIN = 'auto', 'plain'
KEEP = 'keep'
OPTIONAL, REQUIRED = 'optional', 'required'


MOST_JOBS = 2**31 - 1
"""In practice no limit."""


class BadParameter(OrchestratorError):
    """A parameter has a value that is not allowed."""


@dataclass(frozen=True)
class Words:
    """The description of a parameter for users."""

    meaning: str
    choices: tuple[str, ...] = ()
    """The allowed values of a string; empty: any."""
    low: float | None = None
    high: float | None = None
    """The range of a number."""
    metavar: str | None = None
    read: Callable[[str], Any] = Path
    """Of a value that may be left out: what its text names."""


@dataclass(frozen=True)
class NodeParameters:
    """The parameters of a tree node, with their defaults."""

    cell: Annotated[
        Path | None, Words('cell file (YAML; default: cell.yaml in this folder)', metavar='CELL')
    ] = None
    trees: Annotated[
        tuple[Path, ...],
        Words('folders in which scripts are looked up by name, in order', metavar='DIR'),
    ] = ()
    recipes: Annotated[
        tuple[Path, ...],
        Words(
            'folders of recipes, with NAME.overrides.yaml beside NAME.yaml, for orders by recipe',
            metavar='DIR',
        ),
    ] = ()
    reasons: Annotated[
        Path | None,
        Words(
            "file of the plant's reasons for stops of the line (YAML); without it no request may "
            'name one',
            metavar='FILE',
        ),
    ] = None
    script_paths: Annotated[
        bool,
        Words(
            'orders may name scripts outside these folders by their path; then every participant '
            'of the ROS 2 domain can have the node read any file as a script'
        ),
    ] = False
    unauthenticated_role: Annotated[
        str,
        Words(
            'role of all clients in the ROS domain, because ROS does not authenticate them; auto: '
            'engineer where the discovery range of ROS is this computer, else view',
            choices=(AUTO, *(role.value for role in Role)),
        ),
    ] = AUTO
    trust_local_doors: Annotated[
        bool,
        Words(
            'the roles that pages and OPC UA servers assert for their users count, where the '
            'discovery range of ROS is this computer'
        ),
    ] = False
    signed_commands: Annotated[
        str,
        Words(
            'required: only requests that a key of the users file has signed count, all others '
            'have the role view; optional: both do',
            choices=(OPTIONAL, REQUIRED),
        ),
    ] = OPTIONAL
    tick_rate_hz: Annotated[
        float,
        Words(
            'heartbeat of the tree, Hz, while the journal is looked after or py_trees_ros looks '
            'on; otherwise once a second. A result, a command, a state message or the end of a '
            'time limit wakes the tree at once, whatever the rate',
            low=0.1,
            high=1000.0,
            metavar='HZ',
        ),
    ] = 10.0
    executor: Annotated[
        str, Words('rclpy executor; events: where rclpy has it', choices=(SINGLE, EVENTS))
    ] = SINGLE
    client: Annotated[
        str,
        Words(
            'what action clients and the executor use of rclpy; auto: its inside, where it is the '
            'one that is known; plain: only what rclpy promises to keep, at more CPU time',
            choices=(AUTO, PLAIN),
        ),
    ] = AUTO
    auto_start: Annotated[
        bool,
        Words(
            'the cell resets and starts by itself when an order arrives, unless an operator '
            'stopped it'
        ),
    ] = True
    control: Annotated[
        str,
        Words(
            'remote: a line that is in local is in remote again; keep: as it was when the last '
            'node ended',
            choices=(KEEP, Control.REMOTE.value),
        ),
    ] = KEEP
    users: Annotated[
        Path | None,
        Words(
            'file of users with the keys that sign requests, and with the panels, which '
            '`cell local` needs (default: ~/.config/bt_orchestrator/users.yaml); see `user`',
            metavar='FILE',
        ),
    ] = None
    auto_resume: Annotated[
        bool, Words('after a restart with unfinished work, go on without the hold `restarted`')
    ] = False
    journal: Annotated[
        JournalPlace | None,
        Words(
            'the durable journal, an SQLite file or postgresql://USER@HOST/DATABASE/CELL: what '
            'was begun goes on after a crash; without it nothing survives the process',
            metavar='FILE',
            read=journal_place,
        ),
    ] = None
    standby: Annotated[
        bool,
        Words(
            'wait beside the node that runs the cell, and go on when it is gone; the journal has '
            'to be in a database. If no node runs the cell, it begins at once'
        ),
    ] = False
    journal_synchronous: Annotated[
        str,
        Words(
            'FULL: a power cut loses nothing; NORMAL: faster by one fsync a commit, a power cut '
            'may lose the last events, a crash of the program loses nothing',
            choices=('FULL', 'NORMAL'),
        ),
    ] = 'FULL'
    journal_timeout: Annotated[
        float,
        Words(
            'seconds that a commit may take before the journal counts as broken; until then '
            'nothing is sent, commands wait, and requests that only read are answered',
            low=1.0,
            high=3600.0,
            metavar='SECONDS',
        ),
    ] = 15.0
    journal_keep_jobs: Annotated[
        int,
        Words(
            'how many ended jobs keep their events in the journal, at least; of older ones a '
            'summary stays; -1: all',
            low=-1,
            high=MOST_JOBS,
            metavar='N',
        ),
    ] = 1000
    server_timeout: Annotated[
        float,
        Words(
            'seconds that a goal waits for its action server before it fails with '
            'server_unavailable',
            low=0.0,
            high=3600.0,
            metavar='SECONDS',
        ),
    ] = SERVER_TIMEOUT_S
    expected_end: Annotated[
        bool, Words('forecast the ends of jobs, in a process of low priority')
    ] = True
    inspection: Annotated[
        str,
        Words(
            'what tree watchers attach to: builtin, the server of this node, or py_trees_ros, the '
            'server of that package, which has to be installed',
            choices=(BUILTIN, PY_TREES_ROS),
        ),
    ] = BUILTIN

    def __post_init__(self) -> None:
        """Refuse a value that is not one of the choices.

        :raises BadParameter: the message lists the choices
        """
        for name, words in described():
            value = getattr(self, name)
            if words.choices and value not in words.choices:
                expected = ' or '.join(words.choices)
                raise BadParameter(f'parameter {name}: expected {expected}, found {value!r}')


@cache
def described() -> tuple[tuple[str, Words], ...]:
    """Return every parameter with its name, in the order of the documentation."""
    hints = get_type_hints(NodeParameters, include_extras=True)
    return tuple((name, get_args(hint)[1]) for name, hint in hints.items())
