"""A hostile participant of the line's domain: carries out one attack in a process of its own.

    python test/attack/peer.py NAME TARGET SEED SECONDS

TARGET is a file of JSON (`Target`). The last line printed is a report of JSON: what was found
wrong, what was counted, and which goals were sent to controllers.
"""

from __future__ import annotations

import json
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from action_caller import ActionCaller
from bt_orchestrator_interfaces.srv import GetEvents

from bt_orchestrator.ros.qos import create_client

PATIENCE_S = 30.0
"""Who is not answered for that long was not answered."""

_ASK_AGAIN_S = 5.0
"""A service that a client sees may not see the client yet, and then its answer is lost."""

_KEPT = 8
"""Requests that may be open at once: a service keeps ten."""


@dataclass(frozen=True)
class Target:
    """What a hostile peer knows of the line."""

    node: str
    pid: int
    plain_pid: int
    """Of the plain node beside it."""
    journal: str
    folder: str
    """Of the scripts, the cell file and everything else."""
    cell: str
    script: str
    """The name of a script that is good."""


@dataclass
class Report:
    """What an attack has to say."""

    complaints: list[str] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    goals: list[str] = field(default_factory=list)
    """UUIDs of the goals that were sent to controllers past the node."""


class Peer:
    """Everything runs in its caller's thread."""

    def __init__(self, target: Target, drawn: random.Random, seconds: float) -> None:
        self.target = target
        self.drawn = drawn
        self.seconds = seconds
        self.ros = ActionCaller()
        self.report = Report()
        self.folder = Path(target.folder)
        self._until = 0.0
        self._clients: dict[str, Any] = {}
        self._answered: set[str] = set()

    def begin(self) -> None:
        """Let the time run, as soon as the node is found."""
        self.client(GetEvents, 'get_events')
        self._until = time.monotonic() + self.seconds

    def goes_on(self) -> bool:
        """Tell whether there is time left."""
        return time.monotonic() < self._until

    @property
    def left_s(self) -> float:
        """How much."""
        return max(0.0, self._until - time.monotonic())

    def count(self, what: str, number: int = 1) -> None:
        """Count something for the report."""
        self.report.counts[what] += number

    def complain(self, what: str) -> None:
        """Put a fault of the node into the report, once."""
        if what not in self.report.complaints:
            self.report.complaints.append(what)

    def wait(self, seconds: float, unless: Callable[[], Any] = lambda: False) -> bool:
        """Let callbacks run."""
        return self.ros.spin_for(seconds, unless)

    # --- asking -------------------------------------------------------------------------------

    def client(self, kind: Any, service: str) -> Any:
        """Return the client of a service of the node, which is there."""
        if service not in self._clients:
            client: Any = create_client(self.ros.node, kind, f'{self.target.node}/{service}')
            self.ros.spin_until(client.service_is_ready, f'the service {service}')
            self._clients[service] = client
        return self._clients[service]

    def ask(self, kind: Any, service: str, request: Any) -> Any:
        """Return the answer of a service of the node; None, and a complaint, if none comes."""
        (answer,) = self.ask_all(kind, service, [request])
        return answer

    def ask_all(self, kind: Any, service: str, requests: Iterable[Any]) -> Iterator[Any]:
        """Yield the answers, in their order; so many are open at once as a service keeps."""
        client = self.client(kind, service)
        waiting: list[tuple[Any, Any]] = []
        for request in requests:
            waiting.append((request, client.call_async(request)))
            if len(waiting) == _KEPT:
                yield self._answer(client, service, *waiting.pop(0))
        for request, answer in waiting:
            yield self._answer(client, service, request, answer)

    def _answer(self, client: Any, service: str, request: Any, answer: Any) -> Any:
        self.count('requests')
        asked = [answer]
        if service not in self._answered and not self.wait(_ASK_AGAIN_S, answer.done):
            asked.append(client.call_async(request))
        if self.wait(PATIENCE_S, lambda: any(future.done() for future in asked)):
            self._answered.add(service)
            return next(future.result() for future in asked if future.done())
        self.complain(f'{service} gave no answer within {PATIENCE_S:g} s')
        return None

    def pour(self, kind: Any, service: str, requests: Iterable[Any]) -> None:
        """Ask without waiting for answers, while there is time."""
        client = self.client(kind, service)
        for request in requests:
            client.call_async(request)
            self.count('poured')
            self.wait(0.0)
            if not self.goes_on():
                break

    def close(self) -> None:
        """Leave ROS."""
        self.ros.close()


def main(name: str, target: Path, seed: str, seconds: str) -> None:
    """Carry out an attack and print the report."""
    from attack.attacks import ATTACKS

    known = Target(**json.loads(target.read_text()))
    peer = Peer(known, random.Random(f'{name} {seed}'), float(seconds))
    try:
        peer.begin()
        ATTACKS[name].run(peer)
    finally:
        print(json.dumps(vars(peer.report)), flush=True)  # noqa: T201 - for the parent process
        peer.close()


if __name__ == '__main__':
    main(sys.argv[1], Path(sys.argv[2]), *sys.argv[3:])
