"""Attacks by requests to the services of the node."""

from __future__ import annotations

import contextlib
import itertools
import random
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from action_msgs.msg import GoalInfo
from attack import garbage
from attack.attacks.attack import Attack, Bounds
from attack.peer import Peer
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.srv import (
    AnswerHold,
    Command,
    GetEvents,
    QueueCommand,
    RemoveItem,
)
from rclpy.node import NodeNameNonExistentError
from unique_identifier_msgs.msg import UUID

_WHO = 'attacker'

_OF_ROS = ('rcl_interfaces', 'type_description_interfaces')
"""rclpy itself serves these, and does not answer what it cannot read."""


class Garbage(Attack):
    """Something that hurts in every field of every service and action that the node offers."""

    name = 'garbage'

    def run(self, peer: Peer) -> None:
        """Ask every service in turn, and send goals between."""
        services = list(_services(peer))
        peer.count('services', len(services))
        while peer.goes_on():
            for kind, service in services:
                request = garbage.message(peer.drawn, kind.Request)
                if kind.__module__.startswith(_OF_ROS):
                    peer.pour(kind, service, [request])
                else:
                    peer.ask(kind, service, request)
                if not peer.goes_on():
                    break
            self._send_goal(peer)

    def _send_goal(self, peer: Peer) -> None:
        goal = garbage.message(peer.drawn, RunJob.Goal)
        peer.ros.call(f'{peer.target.node}/run_job', RunJob, goal)
        # Zeros would cancel the goals of all clients.
        unknown = UUID(uuid=[peer.drawn.randrange(1, 256) for _ in range(16)])
        kind = RunJob.Impl.GetResultService
        peer.ask(kind, 'run_job/_action/get_result', kind.Request(goal_id=unknown))


class Reasons(Attack):
    """Refused commands with names and reasons of 5 MB."""

    name = 'reasons'
    bounds = Bounds(peak_mb=100.0, grown_mb=80.0)  # DDS keeps the room of its largest messages

    def run(self, peer: Peer) -> None:
        """Give a few of these commands."""
        long = 'a☃\x1b[2J' * 700_000
        most = max(4, min(40, round(peer.seconds * 3)))
        for number in range(most):
            texts = {'who': long if number % 2 else _WHO, 'reason': long, 'origin': long[:1000]}
            for kind, service, fields in (
                (AnswerHold, 'answer_hold', {'hold': '77', 'answer': 'retry'}),
                (Command, 'command', {'command': 'dance'}),
            ):
                answer = peer.ask(kind, service, kind.Request(**fields, **texts))
                if answer is not None and len(answer.message) > 10_000:
                    peer.complain(f'{service} answers with {len(answer.message):,} characters')
            if not peer.goes_on():
                break


class Refusals(Attack):
    """A flood of commands that are all refused."""

    name = 'refusals'

    def run(self, peer: Peer) -> None:
        """Pour them in, first of one sender, then of many."""
        peer.pour(RemoveItem, 'remove_item', self._removals(peer.drawn))

    def _removals(self, drawn: random.Random) -> Iterator[RemoveItem.Request]:
        for number in itertools.count():
            who = _WHO if drawn.random() < 0.8 else f'{_WHO} {number}'
            yield RemoveItem.Request(item=f'none/{number}', who=who, reason=garbage.text(drawn))


class Departures(Attack):
    """Clients that ask a service hundreds of times and leave, of one service after the other."""

    name = 'departures'

    _QUESTIONS = 300
    """More than a service of the node keeps."""

    def run(self, peer: Peer) -> None:
        """Come, ask and go."""
        asked = [*_services(peer), *self._of_run_job()]
        # Who asks what the foreign clock asks keeps it waiting: a service has one queue for all.
        asked = [(kind, service) for kind, service in asked if service != 'get_parameters']
        peer.drawn.shuffle(asked)
        peer.count('services', len(asked))
        for kind, service in itertools.cycle(asked):
            self._ask_and_go(peer, kind, service)
            if not peer.goes_on():
                break

    def _of_run_job(self) -> Iterator[tuple[Any, str]]:
        its = RunJob.Impl
        for kind, name in (
            (its.SendGoalService, 'send_goal'),
            (its.CancelGoalService, 'cancel_goal'),
            (its.GetResultService, 'get_result'),
        ):
            yield kind, f'run_job/_action/{name}'

    def _ask_and_go(self, peer: Peer, kind: Any, service: str) -> None:
        leaver = Peer(peer.target, peer.drawn, 0.0)
        try:
            client = leaver.client(kind, service)
            for _ in range(self._QUESTIONS):
                client.call_async(self._request(kind))
        finally:
            leaver.close()
        peer.count('poured', self._QUESTIONS)

    def _request(self, kind: Any) -> Any:
        if kind is RunJob.Impl.CancelGoalService:
            unknown = GoalInfo(goal_id=UUID(uuid=[1] * 16))  # zeros mean the goals of all
            return kind.Request(goal_info=unknown)
        return kind.Request()


class Pauses(Attack):
    """A flood of pauses and their ends."""

    name = 'pauses'
    bounds = Bounds(journal_mb=10.0)

    def run(self, peer: Peer) -> None:
        """Pause and resume, and leave no pause behind."""
        requests = map(self._request, itertools.cycle(('pause', 'resume')))
        for answer in peer.ask_all(Command, 'command', _while_there_is_time(peer, requests)):
            peer.count('accepted', int(answer is not None and answer.accepted))
        last = Command.Request(command='resume', who=_WHO, reason='attack is over', everyones=True)
        peer.ask(Command, 'command', last)

    def _request(self, command: str) -> Command.Request:
        return Command.Request(command=command, who=_WHO, reason='attack')


class History(Attack):
    """Events asked for by extreme numbers, and jobs that never were."""

    name = 'history'

    _NUMBERS = (0, 1, 2, 200, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)

    def run(self, peer: Peer) -> None:
        """Ask for events, and command jobs by odd names."""
        for answer in peer.ask_all(
            GetEvents, 'get_events', _while_there_is_time(peer, self._requests(peer.drawn))
        ):
            if answer is not None and len(answer.events) > 1000:
                peer.complain(f'get_events answers with {len(answer.events)} events')
        for word in ('clear', 'next', 'abort', 'remove', 'pause'):
            request = QueueCommand.Request(
                command=word, job=garbage.text(peer.drawn), who=_WHO, reason='attack'
            )
            answer = peer.ask(QueueCommand, 'queue/command', request)
            if answer is not None and answer.accepted:
                peer.complain(f'queue/command {word} of a job that never was is accepted')

    def _requests(self, drawn: random.Random) -> Iterator[GetEvents.Request]:
        while True:
            after, most = drawn.choice(self._NUMBERS), drawn.choice(self._NUMBERS)
            yield GetEvents.Request(after_seq=after, most=min(most, 2**32 - 1))


def _while_there_is_time(peer: Peer, requests: Iterator[Any]) -> Iterator[Any]:
    return itertools.takewhile(lambda _: peer.goes_on(), requests)


def _services(peer: Peer) -> Iterator[tuple[Any, str]]:
    """Yield class and name of every service of the node, actions aside."""
    node, space = peer.target.node.rpartition('/')[2], peer.target.node.rpartition('/')[0] or '/'
    services: list[Any] = []

    def look() -> bool:
        with contextlib.suppress(NodeNameNonExistentError):  # not discovered yet
            services[:] = peer.ros.node.get_service_names_and_types_by_node(node, space)
        return any(name.endswith('/command') for name, _ in services)

    peer.ros.spin_until(look, 'the services of the node')
    for name, (type_name,) in sorted(services):
        package, folder, kind = type_name.split('/')
        if '/_action/' not in name:
            service = name.removeprefix(f'{peer.target.node}/')
            yield getattr(import_module(f'{package}.{folder}'), kind), service
