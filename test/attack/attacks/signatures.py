"""Attacks on signed commands (semantics 7.12): of many copies, none may be carried out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from attack.attacks.attack import Attack
from attack.peer import Peer
from bt_orchestrator_interfaces.msg import Status
from bt_orchestrator_interfaces.srv import SignedRequest

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ros.qos import LATCHED
from bt_orchestrator.script.users.file import UsersFile
from bt_orchestrator.script.users.keys import FRESH_S, Key, Place, SigningKey, opened, sealed

USERS = 'users.yaml'
"""The node's file of users, in the folder of the line."""

_RESUMED = 'the cell is not paused'
"""The line's own operator, who resumes whatever is paused, was quicker."""


class Signatures(Attack):
    """Signed commands replayed, delayed, reordered, changed, stolen, from elsewhere."""

    name = 'signatures'

    def run(self, peer: Peer) -> None:
        """Overhear what an operator signs, and send all that can be made of it."""
        line = _Line(peer)
        line.send(SignedRequest.Request())  # an answer to the first one may be lost
        while peer.goes_on():
            for what, forged in (*line.copies(), *line.misplaced(), *line.forged()):
                answer = line.send(forged)
                peer.count(f'{what} refused')
                if answer.accepted:
                    peer.complain(f'a signed command was carried out though {what}: {answer}')
        if peer.seconds > 2 * FRESH_S:
            line.wait_for(peer, FRESH_S + 0.5)


class _Line:
    """What an attacker has: the status, old requests, a viewer's key; and an operator."""

    def __init__(self, peer: Peer) -> None:
        self._peer = peer
        users = UsersFile(peer.folder / USERS)
        self._keys: dict[str, SigningKey] = {}
        for name, role, door in (
            ('operator', Role.ENGINEER, ''),
            ('viewer', Role.VIEW, ''),
            ('page_1', Role.OPERATE, 'page'),
        ):
            self._keys[name] = SigningKey.made(peer.folder / 'keys' / f'{name}.pem')
            users.add_key(name, Key(role, self._keys[name].public, door))
        self._nobody = SigningKey.made(peer.folder / 'keys' / 'nobody.pem')
        self._status: Any = None
        node = peer.ros.node
        node.create_subscription(Status, f'{peer.target.node}/status', self._on_status, LATCHED)
        peer.wait(30.0, lambda: self._status is not None)

    def _on_status(self, status: Any) -> None:
        self._status = status

    def send(self, request: Any) -> Any:
        """Send a request; returns the answer."""
        return self._peer.ask(SignedRequest, 'signed_request', request)

    def _place(self, **other: Any) -> Place:
        up = Uptime(self._status.boot, self._status.uptime)
        return Place(self._peer.target.node, self._status.history, up)._replace(**other)

    def _signed(self, who: str, name: str = 'cell.pause', by: By | None = None, **at: Any) -> Any:
        """Return what the owner of a key would send."""
        key = self._keys[who]
        by = by or By('operator', 'attacked', 'a test')
        return self._of(key, sealed(name, '{}', by, self._place(**at), key.next_number()).text)

    def _of(self, key: SigningKey, text: str) -> Any:
        signature = list(key.sign(text))
        return SignedRequest.Request(request=text, key=key.public, signature=signature)

    def copies(self) -> Iterator[tuple[str, Any]]:
        """Let the operator pause the line and go on, and yield copies of it."""
        pause, resume = self._signed('operator'), self._signed('operator', 'cell.resume')
        overtaken = self._signed('operator')
        for request in (pause, resume):
            answer = self.send(request)
            if answer.accepted:
                self._peer.count('good accepted')
            elif _RESUMED not in answer.message:
                self._peer.complain(f'a good signed command was refused: {answer.message}')
            yield 'replayed', request
        self.send(self._signed('operator', 'cell.resume'))
        yield 'overtaken', overtaken
        yield 'replayed', pause

    def misplaced(self) -> Iterator[tuple[str, Any]]:
        """Yield requests for another node, journal or moment."""
        boot, uptime = self._status.boot, self._status.uptime
        yield 'for another node', self._signed('operator', node='/another')
        yield 'for another journal', self._signed('operator', history='another')
        yield 'for another boot', self._signed('operator', up=Uptime('another', uptime))
        for seconds in (-FRESH_S - 1.5, -3600.0):
            yield 'delayed', self._signed('operator', up=Uptime(boot, uptime + seconds))
        yield 'for later', self._signed('operator', up=Uptime(boot, uptime + 3600.0))

    def forged(self) -> Iterator[tuple[str, Any]]:
        """Yield requests that somebody else has changed or signed."""
        good = self._signed('operator')
        viewer = self._keys['viewer']
        yield 'stolen by a viewer', self._of(viewer, good.request)
        yield (
            'with the key of another',
            SignedRequest.Request(
                request=good.request, key=viewer.public, signature=good.signature
            ),
        )
        yield 'of a viewer', self._signed('viewer')
        changes: tuple[tuple[str, Any], ...] = (
            *(('name', 'cell.abort'), ('who', 'x'), ('number', 2**52)),
        )
        for field, value in changes:
            text = replace(opened(good.request), **{field: value}).text
            yield (
                'changed',
                SignedRequest.Request(request=text, key=good.key, signature=good.signature),
            )
        drawn = [self._peer.drawn.randrange(256) for _ in range(64)]
        yield (
            'without a signature',
            SignedRequest.Request(request=good.request, key=good.key, signature=drawn),
        )
        yield 'of an unknown key', self._of(self._nobody, good.request)
        for known in (Known.OPC_UA_PANEL, Known.ROS):
            by = By('operator', 'attacked', 'a test', Role.ENGINEER, known)
            yield 'of a door for others', self._signed('page_1', by=by)
        engineer = By('operator', 'attacked', 'a test', Role.MES, Known.PAGE_PANEL)
        yield 'of a door above its role', self._signed('page_1', by=engineer)

    def wait_for(self, peer: Peer, seconds: float) -> None:
        """Keep a good request back for real, and bring it late."""
        kept = self._signed('operator')
        peer.wait(seconds)
        if self.send(kept).accepted:
            peer.complain(f'a command was carried out {seconds} s after it was signed')
        peer.count('kept back refused')
