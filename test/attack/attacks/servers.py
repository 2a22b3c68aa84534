"""Attacks by action servers, and at those of the controllers."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from attack import garbage
from attack.attacks.attack import Attack, Bounds
from attack.peer import Peer
from attack.tricky_controllers import NASTY
from bt_orchestrator_interfaces.action import Component
from bt_orchestrator_interfaces.msg import Identity, Status
from bt_orchestrator_interfaces.srv import Command
from chaos.truth import Controllers
from program_process import ProgramProcess
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.ros.qos import LATCHED

ALONE = 'attacker who stays'
"""Owns the pause that nobody else is to release."""

_SPEED = '10'


class Results(Attack):
    """Results with every number and text that ROS 2 can carry, up to 1 MB."""

    name = 'results'
    bounds = Bounds(journal_mb_a_task=0.3, peak_mb=150.0, grown_mb=100.0)

    def run(self, peer: Peer) -> None:
        """Let the untrusted controllers do it."""
        flag = peer.folder / NASTY
        flag.touch()
        peer.wait(peer.seconds)
        flag.unlink()


class SecondServer(Attack):
    """A second server under an action name of the line, which would do its goals once more."""

    name = 'second_server'

    _COMPONENT = 'worker'
    _NOTICED_S = 20.0

    def run(self, peer: Peer) -> None:
        """Come while the line is paused, and see that no goal is sent while there are two."""
        log = peer.folder / 'second_server.jsonl'
        with _paused(peer):
            second = self._start(peer, log)
            says = _Statuses(peer)
            if not peer.wait(self._NOTICED_S, lambda: self._is_noticed(says)):
                peer.complain(f'the status does not name the second server of {self._COMPONENT}')
        try:
            peer.wait(peer.seconds)
        finally:
            second.stop()
        for goal in Controllers(log).by_goal:
            peer.complain(f'of two servers of {self._COMPONENT}, both were sent goal {goal}')

    def _start(self, peer: Peer, log: Path) -> ProgramProcess:
        words = ['sim-cell', '--cell', peer.target.cell, '--only', self._COMPONENT]
        words += ['--speed', _SPEED, '--log', str(log)]
        second = ProgramProcess(words, peer.folder, 'second_server')
        second.wait_ready()
        return second

    def _is_noticed(self, says: _Statuses) -> bool:
        """Tell whether the node says that the component has two servers."""
        components = says.last.components if says.last else []
        return any(c.name == self._COMPONENT and c.contested for c in components)


class ForeignGoals(Attack):
    """Goals sent to controllers past the node."""

    name = 'foreign_goals'

    def run(self, peer: Peer) -> None:
        """Send one after the other; a controller that is busy refuses."""
        while peer.goes_on():
            action = f'/{peer.drawn.choice(("feeder", "worker", "packer"))}/task'
            goal = uuid.UUID(int=peer.drawn.getrandbits(128), version=4)
            peer.report.goals.append(str(goal))
            fields = garbage.message(peer.drawn, Component.Goal)
            fields.task = peer.drawn.choice((Component.Goal.TASK_A, 200))
            client = peer.ros.client(action, Component)
            peer.ros.spin_until(client.server_is_ready, action)
            sent = client.send_goal_async(fields, goal_uuid=UUID(uuid=list(goal.bytes)))
            peer.wait(2.0, sent.done)
            peer.count('goals')
            peer.wait(0.3)


class Cancels(Attack):
    """Goals of the line cancelled by somebody else."""

    name = 'cancels'
    in_short = False  # has a test of its own

    _EVERY_S = 0.5
    _ACTIONS = ('/worker/task', '/camera/task', '/feeder/task')

    def run(self, peer: Peer) -> None:
        """Cancel a goal that runs, now of one controller and now of another."""
        running = {action: _Running(peer, action) for action in self._ACTIONS}
        while peer.goes_on():
            action = peer.drawn.choice(self._ACTIONS)
            if not peer.wait(self._EVERY_S, running[action].is_there):
                continue
            goal = running[action].goal
            answer = peer.ros.cancel_of_another(action, Component, goal)
            peer.count('cancel requests')
            peer.count('cancelled', len(answer.goals_canceling))
            peer.wait(self._EVERY_S)
        if not peer.report.counts['cancelled']:
            peer.complain('every cancel request came too late: nothing was attacked')


class Twin(Attack):
    """A second node of the same name, and words of many that are not there."""

    name = 'twin'
    in_short = False  # has tests of its own

    def run(self, peer: Peer) -> None:
        """Start the one, and say the others."""
        words = ['run', '--cell', peer.target.cell, '--journal', str(peer.folder / 'twin.sqlite3')]
        second = ProgramProcess(words, peer.folder, 'twin')
        try:
            if second.wait(60.0) == 0:
                peer.complain('a second node of the same name ended well')
        except AssertionError:
            peer.complain('a second node of the same name has started')
        finally:
            second.kill()
        topic = f'{peer.target.node}/identity'
        identity = peer.ros.node.create_publisher(Identity, topic, LATCHED)
        while peer.goes_on():
            message = garbage.message(peer.drawn, Identity)
            message.standby = False
            message.instance = uuid.UUID(int=peer.drawn.getrandbits(128)).hex
            identity.publish(message)
            peer.count('identities')
            peer.wait(0.02)


class _Running:
    """Hears which goal a controller carries out, if any."""

    def __init__(self, peer: Peer, action: str) -> None:
        self.goal = ''
        peer.ros.node.create_subscription(
            GoalStatusArray, f'{action}/_action/status', self._hear, LATCHED
        )

    def is_there(self) -> bool:
        return bool(self.goal)

    def _hear(self, message: GoalStatusArray) -> None:
        goals = [row for row in message.status_list if row.status == GoalStatus.STATUS_EXECUTING]
        self.goal = str(uuid.UUID(bytes=bytes(goals[-1].goal_info.goal_id.uuid))) if goals else ''


class _Statuses:
    """Hears the status of the node."""

    def __init__(self, peer: Peer) -> None:
        self.last: Any = None
        topic = f'{peer.target.node}/status'
        peer.ros.node.create_subscription(Status, topic, self._hear, LATCHED)

    def _hear(self, message: Any) -> None:
        self.last = message


@contextmanager
def _paused(peer: Peer) -> Iterator[None]:
    """Keep the line paused, and nothing running."""
    words = {'who': ALONE, 'reason': 'attack'}
    peer.ask(Command, 'command', Command.Request(command='pause', **words))
    says = _Statuses(peer)
    peer.wait(30.0, lambda: says.last and says.last.state == 'Held')
    try:
        yield
    finally:
        peer.ask(Command, 'command', Command.Request(command='resume', **words))
