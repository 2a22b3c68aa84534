"""Attacks by work orders."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from typing import Any

from attack.attacks.attack import Attack, Bounds
from attack.peer import Peer
from attack.plain_node import NAME
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import WorkOrder
from bt_orchestrator_interfaces.srv import QueueAdd, QueueCommand, SubmitOrder
from diagnostic_msgs.msg import KeyValue
from patience import PATIENCE_S
from rcl_interfaces.srv import GetParameters

from bt_orchestrator.ros.qos import create_client

_SECRET = 'attack-secret'

_FOREIGN = (
    '/proc/kmsg',
    '/etc/shadow',
    '/etc/passwd',
    '/dev/zero',
    '/dev/stdin',
    '/proc/self/mem',
    '../../../../../../etc/passwd',
    '../secret/secret.yaml',
    '..',
    '.',
    '/',
    'pipe',
    'pipe.yaml',
    'folder',
    'folder.yaml',
    'pipe.yaml/../../secret/secret',
    'a' * 5000,
)

_LARGEST = 60_000_000
"""Bytes of a message."""

_MOST_FINDINGS = 101
"""A hundred, and a sentence about the rest."""


class Paths(Attack):
    """Orders that name devices, pipes, folders, and files that are none of theirs."""

    name = 'paths'

    def run(self, peer: Peer) -> None:
        """Name them one after the other."""
        names = [*_FOREIGN, *self._lay_out(peer)]
        while peer.goes_on():
            peer.drawn.shuffle(names)
            for name in names:
                peer.count('paths')
                _refused(peer, name[:40], _submit(peer, script=name))
                text = f'order: X\nscript: {name}\nquantity: 1\n'
                _refused_goal(peer, name[:40], RunJob.Goal(text=text))

    def _lay_out(self, peer: Peer) -> list[str]:
        """Put what hurts where orders may look, and a secret where they may not."""
        for name in ('folder.yaml', 'secret'):
            (peer.folder / name).mkdir(exist_ok=True)
        secret = peer.folder / 'secret' / 'secret.yaml'
        secret.write_text(f'script: {_SECRET}\nsections: [{_SECRET}\n')
        outside = peer.folder.parent / 'outside.yaml'
        outside.write_text(secret.read_text())
        pipe = peer.folder / 'pipe.yaml'
        if not pipe.exists():
            os.mkfifo(pipe)
        return [str(outside), '../outside.yaml', str(pipe)]


class Large(Attack):
    """Orders of 60 MB, of 199,000 lines, with 100,000 mistakes, and of aliases of aliases."""

    name = 'large'
    bounds = Bounds(peak_mb=700.0, grown_mb=200.0, plain_too=True)

    def run(self, peer: Peer) -> None:
        """Give each once, in any order, as long as there is time."""
        attacks = [
            *[partial(_refused_goal, peer, name, goal) for name, goal in _texts()],
            *[partial(self._file, peer, name, text) for name, text in _scripts()],
            partial(self._parameter, peer),
            partial(self._orders, peer),
            partial(self._plain, peer),
        ]
        peer.drawn.shuffle(attacks)
        for attack in attacks:
            attack()
            peer.count('large requests')
            if not peer.goes_on():
                return

    def _file(self, peer: Peer, name: str, text: str) -> None:
        (peer.folder / f'{name}.yaml').write_text(text)
        _refused(peer, name, _submit(peer, script=name))

    def _parameter(self, peer: Peer) -> None:
        pairs = [KeyValue(key='a', value='b' * 20_000_000)]
        order = SubmitOrder.Request(script=peer.target.script, quantity=1, params=pairs)
        _refused(peer, '20 MB of a parameter', peer.ask(SubmitOrder, 'submit_order', order))

    def _orders(self, peer: Peer) -> None:
        wrong = [WorkOrder(script='none', order=f'X{n}') for n in range(20_000)]
        answer = peer.ask(QueueAdd, 'queue/add', QueueAdd.Request(orders=wrong))
        _refused(peer, '20,000 wrong orders at once', answer)

    def _plain(self, peer: Peer) -> None:
        """Give 60 MB to the plain node: what they cost rclpy is not the node's doing."""
        client: Any = create_client(peer.ros.node, GetParameters, f'/{NAME}/get_parameters')
        peer.ros.spin_until(client.service_is_ready, 'the plain node')
        few, much = (GetParameters.Request(names=['a' * size]) for size in (1, _LARGEST))
        peer.ros.spin_until(lambda: peer.wait(1.0, client.call_async(few).done), 'its answer')
        peer.wait(PATIENCE_S, client.call_async(much).done)


class Orders(Attack):
    """Thousands of good orders, which are taken out again."""

    name = 'orders'
    bounds = Bounds(peak_mb=250.0, grown_mb=150.0, journal_mb=25.0)

    _MOST = 10_000
    _A_SECOND = 500
    _AT_ONCE = 100

    def run(self, peer: Peer) -> None:
        """Queue them, held, and remove each."""
        wanted = min(self._MOST, round(peer.seconds * self._A_SECOND))
        for answer in peer.ask_all(QueueAdd, 'queue/add', self._requests(peer, wanted)):
            if answer is not None and not answer.accepted:
                peer.complain(f'good orders are refused: {answer.message[:200]}')
        peer.count('orders', wanted)
        removals = (_removal(self._id(n)) for n in range(wanted))
        for answer in peer.ask_all(QueueCommand, 'queue/command', removals):
            if answer is not None and not answer.accepted:
                peer.complain(f'a queued order is not removed: {answer.message[:200]}')

    def _requests(self, peer: Peer, wanted: int) -> Iterator[QueueAdd.Request]:
        for first in range(0, wanted, self._AT_ONCE):
            numbers = range(first, min(wanted, first + self._AT_ONCE))
            script = peer.target.script
            orders = [WorkOrder(order=self._id(n), script=script, quantity=1) for n in numbers]
            yield QueueAdd.Request(orders=orders, held=True, who='attacker', reason='attack')

    def _id(self, number: int) -> str:
        return f'X-{number}'


class Goals(Attack):
    """Orders given as goals of run_job by the hundred, and cancelled at once."""

    name = 'goals'
    bounds = Bounds(journal_mb=6.0)

    _AT_ONCE = 5
    _A_SECOND = 30

    def run(self, peer: Peer) -> None:
        """Send some, cancel them as they are accepted, and wait for their results."""
        number = 0
        while number < peer.seconds * self._A_SECOND and peer.goes_on():
            handles = [self._send(peer, number + n) for n in range(self._AT_ONCE)]
            number += self._AT_ONCE
            ends = []
            for handle in handles:
                accepted = peer.ros.wait(handle, 'run_job to accept a goal')
                accepted.cancel_goal_async()
                ends.append(accepted.get_result_async())
            for end in ends:
                if not peer.wait(60.0, end.done):
                    peer.complain('a cancelled goal of run_job has not ended after 60 s')
            peer.count('goals', self._AT_ONCE)

    def _send(self, peer: Peer, number: int) -> Any:
        order = WorkOrder(order=f'G-{number}', script=peer.target.script, quantity=1)
        goal = RunJob.Goal(order=order, who='attacker', reason='attack')
        return peer.ros.request(f'{peer.target.node}/run_job', RunJob, goal)


def _texts() -> Iterator[tuple[str, RunJob.Goal]]:
    """Yield work orders that are too large, and what is large in them."""
    yield '60 MB of text', RunJob.Goal(text='order: X\n' + '# x\n' * (_LARGEST // 4))
    yield '199,000 lines', RunJob.Goal(text='order: X\nscript: x\n' + 'quantity: 1\n' * 199_000)
    wrong = ''.join(f'k{n}: v\n' for n in range(100_000))
    yield '100,000 mistakes', RunJob.Goal(text=wrong)
    yield 'aliases', RunJob.Goal(text=_bomb())
    yield 'depth', RunJob.Goal(text='order: ' + '[' * 200_000)


def _scripts() -> Iterator[tuple[str, str]]:
    yield 'long', 'script: long\nsections:\n  1:\n' + '    - {id: a, task: A}\n' * 199_000
    yield 'aliased', _bomb()
    yield 'deep', '{a: ' * 100_000


def _bomb() -> str:
    lines = ['a0: &a0 [x, x, x, x, x, x, x, x, x]']
    lines += [f'a{n}: &a{n} [{", ".join([f"*a{n - 1}"] * 9)}]' for n in range(1, 12)]
    return '\n'.join([*lines, 'script: *a11', ''])


def _submit(peer: Peer, **order: Any) -> Any:
    request = SubmitOrder.Request(quantity=1, who='attacker', reason='attack', **order)
    return peer.ask(SubmitOrder, 'submit_order', request)


def _removal(job: str) -> QueueCommand.Request:
    return QueueCommand.Request(command='remove', job=job, who='attacker', reason='attack')


def _refused(peer: Peer, what: str, answer: Any) -> None:
    """Complain unless an answer is a refusal, of a modest size, that quotes no secret."""
    if answer is None:
        return
    if answer.accepted:
        peer.complain(f'accepted: {what}')
    findings = getattr(answer, 'findings', None) or [
        finding for reply in getattr(answer, 'answers', ()) for finding in reply.findings
    ]
    _judge_words(peer, what, answer.message, findings)


def _refused_goal(peer: Peer, what: str, goal: RunJob.Goal) -> None:
    handle = peer.ros.start(f'{peer.target.node}/run_job', RunJob, goal)
    if not handle.accepted:
        return
    result = peer.ros.result(handle).result
    if result.exit_status != 'refused':
        peer.complain(f'run_job ended with {result.exit_status!r}: {what}')
    _judge_words(peer, what, result.message, result.findings)


def _judge_words(peer: Peer, what: str, message: str, findings: Any) -> None:
    text = ' '.join([message, *findings])
    if _SECRET in text or 'root:' in text:
        peer.complain(f'the answer to {what} quotes a file: {text[:200]}')
    if len(findings) > _MOST_FINDINGS:
        peer.complain(f'the answer to {what} has {len(findings)} findings')
    if len(text) > 200_000:
        peer.complain(f'the answer to {what} has {len(text):,} characters')
