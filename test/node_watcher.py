"""A client of a tree node, for tests: every event, the last status, and the services."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from action_caller import ActionCaller
from bt_orchestrator_interfaces.msg import Event, Status
from bt_orchestrator_interfaces.srv import (
    AnswerHold,
    Command,
    GetEvents,
    RemoveItem,
    SubmitOrder,
)
from diagnostic_msgs.msg import KeyValue
from patience import PATIENCE_S
from rclpy.qos import QoSProfile

from bt_orchestrator.ros.qos import EVENTS, LATCHED, create_client

WHO = 'tester'

MISSED_S = 3.0
"""An event that was not heard by then was made before the node knew of its listener."""

ALL_EVENTS = QoSProfile(depth=10_000, reliability=EVENTS.reliability)
"""A test may be busy elsewhere for a minute: a line has more events then than its QoS keeps."""


class NodeWatcher:
    """Hears everything that a tree node says from `connect` on. Everything runs in its caller."""

    def __init__(self, name: str = '/bt_orchestrator') -> None:
        self.name = name
        self.ros = ActionCaller()
        self.events: list[dict[str, Any]] = []
        self._asked: list[dict[str, Any]] = []
        """Those that were asked for: the topic may bring them yet."""
        self.statuses: list[Any] = []
        self._clients: dict[str, Any] = {}

    def connect(self, *, wait_servers: bool = True) -> None:
        """Wait for the node, and for its view of its servers.

        The events are subscribed to first: once the latched status has come, the node knows of
        both subscriptions, and no event is missed.
        """
        self._listen()
        self.ros.spin_until(lambda: self.statuses, f'the status of {self.name}')
        if wait_servers:
            self.wait_servers()

    def connect_anew(self) -> None:
        """Do what people do who hear nothing: begin again, in a fresh participant.

        A participant that has seen dozens of nodes die may be discovered by the next one in part
        only, for good (docs/decisions/0018).
        """
        self.ros.close()
        self.ros = ActionCaller()
        self._clients.clear()
        self._listen()

    def wait_servers(self, but: str = '') -> None:
        """Wait until the node sees every action server, except that of one component."""
        self.ros.spin_until(
            lambda: all(c.available or c.name == but for c in self.status.components),
            'every action server at the node',
        )

    def close(self) -> None:
        """Leave ROS."""
        self.ros.close()

    # --- what was heard -----------------------------------------------------------------------

    @property
    def status(self) -> Any:
        """The last status."""
        return self.statuses[-1]

    def seen(self, event: str, **about: Any) -> list[dict[str, Any]]:
        """Return the events of a name that have these values."""
        return [e for e in self.events if e['event'] == event and about.items() <= e.items()]

    def assert_gapless(self) -> None:
        """Fail if an event is missing, or out of order, since the first one that was heard."""
        numbers = [event['seq'] for event in self.events]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))

    def reasons(self, task: str) -> list[str]:
        """Return why the attempts at a task failed, in order."""
        return [event['reason'] for event in self.seen('task.failed', task=task)]

    def until(self, event: str, count: int = 1, **about: Any) -> dict[str, Any]:
        """Wait for the last of so many events of a name with these values, and return it."""
        if not self._comes(lambda: len(self.seen(event, **about)) >= count):
            last = self.events[-8:]
            raise AssertionError(f'waited for {count} {event} {about}; the last were {last}')
        return self.seen(event, **about)[count - 1]

    def until_status(self, condition: Callable[[Any], object], what: str) -> Any:
        """Wait for a status of which a condition holds, and for the events before it."""
        is_so = self._comes(lambda: condition(self.status) and self._has_heard_all())
        assert is_so, f'waited {PATIENCE_S:g} s for {what}'
        return self.status

    def _has_heard_all(self) -> bool:
        """Tell whether the events are as far as the status, which another topic brings."""
        return not self.events or self.events[-1]['seq'] >= self.status.seq

    def until_held(self) -> Any:
        """Wait until the cell is Held by one hold, and return that of the status."""
        status = self.until_status(lambda s: s.state == 'Held' and s.holds, 'the cell to be Held')
        (hold,) = status.holds
        return hold

    def until_ended(self, job: str, within_s: float = PATIENCE_S) -> Any:
        """Wait until a job has ended, and return its status."""
        done = self._comes(
            lambda: self.seen('job.completed', job=job) or self.seen('job.aborted'), within_s
        )
        assert done, f'waited {within_s:g} s for {job}; the last were {self.events[-8:]}'
        status = self.until_status(lambda s: _job(s, job).state == 'Ended', f'{job} to be Ended')
        return _job(status, job)

    def _comes(self, condition: Callable[[], Any], within_s: float = PATIENCE_S) -> bool:
        """Wait for something about events; tell whether it came.

        A node that was started again makes its first ones before it knows who listens. So those
        that do not come are asked for, as any client may do.
        """
        deadline = time.monotonic() + within_s
        while not self.ros.spin_for(min(MISSED_S, deadline - time.monotonic()), condition):
            if time.monotonic() >= deadline:
                return False
            self._ask_for_missed()
        return True

    def _ask_for_missed(self) -> None:
        """Put the first events that are missing in their place."""
        client = self.client(GetEvents, 'get_events')
        if not (self.events and self.statuses and client.service_is_ready()):
            return
        heard = [*(event['seq'] for event in self.events), self.status.seq + 1]
        gaps = [(seq, after) for seq, after in pairwise(heard) if after > seq + 1]
        if gaps:
            (before, after), *_ = gaps
            request = GetEvents.Request(after_seq=before, most=after - before - 1)
            future = client.call_async(request)
            if not self.ros.spin_for(MISSED_S, future.done):
                return  # the node has ended meanwhile
            records = [json.loads(e.record) for e in future.result().events if e.seq < after]
            self._asked += [record for record in records if record not in self.events]
            place = heard.index(before) + 1
            self.events[place:place] = [r for r in records if r not in self.events]

    # --- asking -------------------------------------------------------------------------------

    def submit(self, script: Path | str, **fields: Any) -> Any:
        """Submit an order as `ask_submit` does; it must be accepted."""
        response = self.ask_submit(script, **fields)
        assert response.accepted, [response.message, *response.findings]
        return response

    def ask_submit(
        self,
        script: Path | str,
        *,
        quantity: int = 1,
        order: str = 'WO-1',
        params: Mapping[str, str] | None = None,
    ) -> Any:
        """Submit an order and return the response."""
        pairs = [KeyValue(key=key, value=value) for key, value in (params or {}).items()]
        request = SubmitOrder.Request(
            order=order, script=str(script), quantity=quantity, params=pairs
        )
        return self.call(SubmitOrder, 'submit_order', request)

    def answer(self, hold: str, answer: str) -> Any:
        """Answer a hold and return the response."""
        request = AnswerHold.Request(hold=hold, answer=answer, who=WHO, reason='test')
        return self.call(AnswerHold, 'answer_hold', request)

    def send(self, kind: Any, service: str, **fields: Any) -> Any:
        """Call a service of a node that may be gone; return the future of its response."""
        request = kind.Request(who=WHO, reason='test', **fields)
        return self.client(kind, service).call_async(request)

    def remove(self, item: str) -> Any:
        """Take an item off the belt and return the response."""
        request = RemoveItem.Request(item=item, who=WHO, reason='test')
        return self.call(RemoveItem, 'remove_item', request)

    def command(self, command: str, who: str = WHO, **more: Any) -> Any:
        """Command the cell and return the response."""
        request = Command.Request(command=command, who=who, reason='test', **more)
        return self.call(Command, 'command', request)

    def until_state(self, state: str) -> Any:
        """Wait for a state of the cell, and return the status that says it."""
        return self.until_status(lambda s: s.state == state, f'the cell to be {state}')

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service of the node and return its response."""
        return self.ros.wait(self.begin(kind, service, request), f'an answer of {service}')

    def begin(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service of the node and return the future of its response."""
        client = self.client(kind, service)
        self.ros.spin_until(client.service_is_ready, f'the service {service}')
        self._be_known()
        return client.call_async(request)

    def client(self, kind: Any, service: str) -> Any:
        """Return the client of a service of the node; neither may have found the other yet."""
        if service not in self._clients:
            name = f'{self.name}/{service}'
            self._clients[service] = create_client(self.ros.node, kind, name)
        return self._clients[service]

    def _listen(self) -> None:
        node = self.ros.node
        node.create_subscription(Event, f'{self.name}/events', self._on_event, ALL_EVENTS)
        node.create_subscription(Status, f'{self.name}/status', self.statuses.append, LATCHED)

    def _be_known(self) -> None:
        """Wait for the latched status once more: then the node knows what was made before it."""
        latched: list[Any] = []
        node = self.ros.node
        subscription = node.create_subscription(
            Status, f'{self.name}/status', latched.append, LATCHED
        )
        self.ros.spin_until(lambda: latched, f'the status of {self.name}')
        node.destroy_subscription(subscription)

    def _on_event(self, message: Any) -> None:
        record = json.loads(message.record)
        assert (message.seq, message.event) == (record['seq'], record['event'])
        if record not in self._asked:
            self.events.append(record)


def _job(status: Any, name: str) -> Any:
    return next((job for job in status.jobs if job.id == name), _Unknown)


class _Unknown:
    state = 'unknown'
