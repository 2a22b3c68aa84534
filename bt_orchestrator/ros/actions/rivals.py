"""Other servers of one action, and goals at them that are not ours (semantics 2.5, 9.2)."""

from __future__ import annotations

import math
import os
import time
import uuid
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from types import MappingProxyType

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo

from bt_orchestrator.model.goal import Contest, SeenContest
from bt_orchestrator.ros.actions.fresh_participant import RenewableClient
from bt_orchestrator.ros.actions.goal_client import GoalClient, endpoint_id
from bt_orchestrator.ros.actions.open_goals import OpenGoals

UNNAMED = '_NODE_NAME_UNKNOWN_'
"""As rmw writes it."""


def is_named(endpoint: TopicEndpointInfo) -> bool:
    """Tell whether it is known whose it is: that comes a moment after the endpoint itself."""
    return endpoint.node_name != UNNAMED


def owners(endpoints: Sequence[TopicEndpointInfo]) -> tuple[str, ...]:
    """Return the full names of the nodes; where names are equal, with the ids of the endpoints."""
    nodes = sorted((owner(endpoint), endpoint_id(endpoint)) for endpoint in endpoints)
    count = Counter(name for name, _ in nodes)
    return tuple(name if count[name] == 1 else f'{name} (id {id_})' for name, id_ in nodes)


_FAST_DDS = bytes((1, 15))
"""Vendor of an endpoint id, as DDSI-RTPS numbers them."""

_PROC = Path('/proc')


def place(endpoint: Sequence[int], own: Sequence[int], proc: Path = _PROC) -> str:
    """Say on which computer and in which process an endpoint is; empty: its id does not tell.

    Fast DDS makes the id of a participant of its vendor, two bytes of the computer and the lower
    two of the process. Other middlewares draw theirs at random.

    :param own: the id of an endpoint of this process
    """
    there, here = bytes(endpoint), bytes(own)
    process = slice(4, 6)
    if there[:2] != _FAST_DDS or here[:2] != _FAST_DDS or here[process] != _lower(os.getpid()):
        return ''
    if there[2:4] != here[2:4]:
        return 'on another computer'
    pids = [int(folder.name) for folder in proc.glob('[0-9]*') if folder.name.isdecimal()]
    fit = [pid for pid in sorted(pids) if _lower(pid) == there[process]]
    return f'process {fit[0]} on this computer' if len(fit) == 1 else 'on this computer'


def placed(
    endpoints: Sequence[TopicEndpointInfo],
    own: Sequence[int],
    remarks: Mapping[str, str] = MappingProxyType({}),
) -> Iterator[str]:
    """Yield the nodes as `owners`, each with where it is, if its id tells.

    :param own: the id of an endpoint of this process; empty: it is not known
    :param remarks: more to say, by the ids of endpoints
    """
    by_name = sorted(endpoints, key=lambda endpoint: (owner(endpoint), endpoint_id(endpoint)))
    for name, endpoint in zip(owners(endpoints), by_name, strict=True):
        where = place(endpoint.endpoint_gid, own) if own else ''
        remark = ', '.join(filter(None, [remarks.get(endpoint_id(endpoint), ''), where]))
        yield f'{name} ({remark})' if remark else name


def _lower(pid: int) -> bytes:
    return (pid & 0xFFFF).to_bytes(2, 'little')


def names(endpoints: Sequence[TopicEndpointInfo]) -> str:
    """Return who they belong to, as one text."""
    return ', '.join(owners(endpoints))


def owner(endpoint: TopicEndpointInfo) -> str:
    """Return the full name of the node."""
    if not is_named(endpoint):
        return 'a node without name'
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'


DISCOVERY_S = 3.5
"""Seconds in which a fresh participant finds every live server: they announce every 3 s."""

RIVALS_FRESH_S = 1.0
"""Longest age of a participant that cannot know a server that has just died."""

TRIAL_S = 10.0
"""Shortest time between two fresh looks of one action; a participant is made for each."""

LOOK_S = 0.02
"""How old a look may be; discovery takes longer to find a server."""

MOST_TOLD = 16
"""Most servers that a message names: there may be any number, and messages are recorded."""


class Rivals:
    """Counts the servers of one action in the ROS graph, at next to no cost while there is one.

    A server that was killed stays in the graph for its lease, 20 s. A participant made after its
    death is not told of it, so one is made as soon as there seem to be several. If that finds one
    server only, once everybody alive had the time to be found, it is spoken with from then on.
    """

    def __init__(self, clients: RenewableClient, fresh_node: Callable[[], Node]) -> None:
        self._clients = clients
        self._fresh_node = fresh_node
        self._names: tuple[str, ...] = ()
        self._ids: Sequence[str] = ()
        self._are_named = False
        self._trial: Node | None = None
        self._tried_s = -math.inf
        self._tried_ids: Sequence[str] | None = None
        self._seen_s = -math.inf
        self._looked_s = -math.inf

    def glance(self) -> tuple[str, ...]:
        """Return the same as `look`, by the last look while one server at most tells its status.

        A look goes through the whole graph, which takes 0.15 ms in a node at work; this does not.
        """
        return self.look() if self._clients.current.status.publishers > 1 else self._names

    def look(self) -> tuple[str, ...]:
        """Return all servers that are there now, if there are several; else nothing.

        How many tell their status is asked each time; the graph is gone through if the last look
        is too old.
        """
        now = time.monotonic()
        is_news = not self._names and self._clients.current.status.publishers > 1
        if is_news or now - self._looked_s >= LOOK_S:
            self._looked_s = now
            self._look(now)
        return self._names

    def _look(self, now: float) -> None:
        client = self._clients.current
        if client.count_servers() < 2:
            self._names, self._ids, self._trial = (), (), None
            return
        self._seen_s = now
        publishers = client.status.publishers_info()
        ids = sorted(map(endpoint_id, publishers))
        # The names of nodes come a moment after what they serve.
        if not self._names or ids != self._ids or not self._are_named:
            self._ids, self._are_named = ids, all(map(is_named, publishers))
            names = (*_told(client, publishers), *_without_status(client, len(publishers)))
            self._names = names[:MOST_TOLD]

    def look_afresh(self) -> None:
        """Find out whether all but one are dead; to be called once a second."""
        now = time.monotonic()
        if not self.look():
            return
        if self._trial is None:
            # A server that a fresh look found alive is not looked for again.
            if self._ids != self._tried_ids and now - self._tried_s >= TRIAL_S:
                self._trial, self._tried_s, self._tried_ids = self._fresh_node(), now, self._ids
        elif now - self._tried_s >= DISCOVERY_S:
            count = self._clients.current.count_servers(self._trial)
            if not count:
                return  # discovery takes longer than it should; with nobody found, nobody is dead
            trial, self._trial = self._trial, None
            if count == 1:
                self._clients.renew(trial)
                self._names, self._looked_s = (), -math.inf

    def seen_within(self, seconds: float) -> bool:
        """Tell whether there are several servers now, or were a moment ago."""
        return bool(self.look()) or time.monotonic() - self._seen_s < seconds

    @property
    def nodes(self) -> Iterator[Node]:
        """Nodes that it looks through."""
        if self._trial is not None:
            yield self._trial


def _told(client: GoalClient, publishers: Sequence[TopicEndpointInfo]) -> Iterator[str]:
    """Name those who publish the status of an action: whether they serve it, and where they are.

    Anybody can publish it, and thereby stop the component.
    """
    is_served = len(publishers) <= client.count_takers()
    takers = () if is_served else client.takers()
    alone = {
        endpoint_id(publisher): 'publishes its status and takes no goals'
        for publisher in publishers
        if not is_served and is_named(publisher) and owner(publisher) not in takers
    }
    return placed(publishers, client.status.own_endpoint(), alone)


def _without_status(client: GoalClient, with_status: int) -> Iterator[str]:
    """Name servers that take goals and publish no status, as an action server has to."""
    count = client.count_servers() - with_status
    if count < 1:
        return
    publishers = set(owners(client.status.publishers_info()))
    others = [name for name in client.takers() if name not in publishers]
    yield from (f'{name} (publishes no status)' for name in others[:count])
    yield from ['one that publishes no status'] * (count - len(others[:count]))


# Goals that run at a server and that this process neither sent nor took over (2.5, 9.2).

LATCHED_S = 3.0
"""Seconds after a server was found in which its latched status comes, on a busy machine too."""

MOST_STRANGE = 8
"""At most so many goals are named: a status may list any number, and the journal keeps the names.
"""


class Strangers:
    """Reads them from the server's status, which lists the goals of all clients."""

    def __init__(self, clients: RenewableClient, goals: OpenGoals) -> None:
        self._clients = clients
        self._goals = goals
        self.forget()

    def forget(self) -> None:
        """Begin anew: what runs from now on was begun before this node led the cell."""
        self._found_s: float | None = None
        self._before: dict[str, float] = {}

    def seen(self, component: str, servers: tuple[str, ...]) -> SeenContest:
        """Say who else has a part in the component now.

        :param servers: those of its action, if there are several
        """
        status = self._clients.current.status
        strange = islice(self._strange(), MOST_STRANGE)
        goals = {str(uuid.UUID(bytes=goal)): status.accepted_s(goal) for goal in strange}
        if self._is_early():
            self._before |= goals
        before = {goal: since for goal, since in goals.items() if goal in self._before}
        node = names(status.publishers_info()) if goals else ''
        return SeenContest(component, Contest(servers, tuple(sorted(goals))), node, before)

    def _strange(self) -> Iterator[bytes]:
        status = self._clients.current.status
        if status.is_published:
            yield from (goal for goal in status.active() if not self._goals.is_ours(goal))

    def _is_early(self) -> bool:
        """Tell whether what runs may have been begun before this process found the server."""
        now = time.monotonic()
        if self._found_s is None and self._clients.current.status.is_published:
            self._found_s = now
        return self._found_s is not None and now - self._found_s < LATCHED_S
