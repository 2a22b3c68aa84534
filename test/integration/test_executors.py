"""What the node spins on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import pytest
from action_msgs.srv import CancelGoal
from patience import PATIENCE_S
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.timer import Timer
from rclpy.waitable import NumberOfEntities, Waitable
from std_msgs.msg import Empty

from bt_orchestrator.ros.executor.executors import spin_once
from bt_orchestrator.ros.executor.lean_executor import LeanExecutor
from bt_orchestrator.ros.executor.lean_parts import LeanQuestions, PartedWaitable
from bt_orchestrator.ros.executor.lean_waits import SERVICE
from bt_orchestrator.ros.executor.ways import Service
from bt_orchestrator.ros.qos import quieten

pytestmark = pytest.mark.every_distro


class WaitCounter(Waitable):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Is never ready, and counts how often an executor asked."""

    def __init__(self, node: Node, group: CallbackGroup | None = None) -> None:
        super().__init__(group or node.default_callback_group)
        self.waits = 0
        node.add_waitable(self)

    def get_num_entities(self) -> NumberOfEntities:
        return NumberOfEntities(0, 0, 0, 0, 0)

    def add_to_wait_set(self, wait_set: Any) -> None:
        self.waits += 1

    def is_ready(self, wait_set: Any) -> bool:
        return False

    def take_data(self) -> None:
        raise AssertionError('never ready')

    async def execute(self, taken_data: Any) -> None:
        raise AssertionError('never ready')

    def __enter__(self) -> None:
        pass

    def __exit__(self, *exception: object) -> None:
        pass


@pytest.fixture
def node(context: Context) -> Iterator[Node]:
    node = Node('executors', context=context)
    yield node
    node.destroy_node()


def spin_until(executor: Executor, condition: Callable[[], Any], what: str) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, what
        spin_once(executor, 1.0)


def wait_until_ready(*timers: Timer) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not all(timer.is_ready() for timer in timers):
        assert time.monotonic() < deadline


def waits_for_callbacks(executor: Executor, node: Node, callbacks: int) -> int:
    """Return how often an executor waits until a timer has called back so often."""
    called: list[int] = []
    counter = WaitCounter(node)
    timer = node.create_timer(0.02, lambda: called.append(1))
    executor.add_node(node)
    spin_until(executor, lambda: len(called) >= callbacks, 'the callbacks')
    node.destroy_timer(timer)
    return counter.waits


class TestLeanExecutor:
    @pytest.fixture
    def executor(self, context: Context) -> Iterator[LeanExecutor]:
        executor = LeanExecutor(context=context)
        yield executor
        executor.shutdown()

    def test_waits_once_a_callback(self, executor: LeanExecutor, node: Node) -> None:
        assert waits_for_callbacks(executor, node, 10) <= 11

    def test_its_base_waits_twice(self, context: Context, node: Node) -> None:
        """Where this fails, rclpy does no more what LeanExecutor is there for."""
        executor = SingleThreadedExecutor(context=context)
        assert waits_for_callbacks(executor, node, 10) >= 18
        executor.shutdown()

    @pytest.mark.parametrize('ask', [LeanExecutor.create_task, LeanExecutor.soon])
    def test_what_another_thread_asks_for_ends_a_wait(
        self, executor: LeanExecutor, node: Node, ask: Callable[..., object]
    ) -> None:
        executor.add_node(node)
        spin_once(executor, 0.0)
        done: list[int] = []
        thread = threading.Timer(0.2, lambda: ask(executor, lambda: done.append(1)))
        thread.start()
        began = time.monotonic()
        while not done and time.monotonic() < began + PATIENCE_S:
            spin_once(executor, PATIENCE_S)
        thread.join()
        assert time.monotonic() < began + PATIENCE_S

    def test_task_from_callback_runs_before_next_wait(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        seen: list[int] = []
        counter = WaitCounter(node)

        def call() -> None:
            timer.cancel()
            waits = counter.waits
            executor.create_task(lambda: seen.append(counter.waits - waits))

        timer = node.create_timer(0.01, call)
        executor.add_node(node)
        spin_until(executor, lambda: seen, 'the task')
        assert seen == [0]

    def test_soon_call_from_callback_runs_once_before_wait(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        seen: list[int] = []
        counter = WaitCounter(node)

        def call() -> None:
            timer.cancel()
            waits = counter.waits
            executor.soon(lambda: seen.append(counter.waits - waits))

        timer = node.create_timer(0.01, call)
        executor.add_node(node)
        spin_until(executor, lambda: seen, 'the call')
        spin_once(executor, 0.02)
        assert seen == [0]

    def test_nested_soon_call_runs_after_a_poll(self, executor: LeanExecutor, node: Node) -> None:
        seen: list[int] = []
        counter = WaitCounter(node)
        executor.add_node(node)
        began = time.monotonic()
        executor.soon(lambda: executor.soon(lambda: seen.append(counter.waits)))
        spin_once(executor, PATIENCE_S)
        spin_once(executor, PATIENCE_S)
        assert seen == [1]
        assert time.monotonic() < began + PATIENCE_S

    def test_self_rescheduling_call_does_not_starve_timers(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        calls: list[int] = []
        served: list[int] = []

        def call() -> None:
            calls.append(1)
            executor.soon(call)

        timer = node.create_timer(0.01, lambda: served.append(len(calls)))
        executor.add_node(node)
        wait_until_ready(timer)
        executor.soon(call)
        for _ in range(10):
            spin_once(executor, 0.0)
        assert served
        assert served[0] == 1

    def test_shutdown_by_another_thread_ends_a_wait(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        executor.add_node(node)
        ended: list[bool] = []
        thread = threading.Timer(0.2, lambda: ended.append(executor.shutdown(PATIENCE_S)))
        thread.start()
        began = time.monotonic()
        spin_once(executor, PATIENCE_S)
        thread.join()
        assert ended == [True]
        assert time.monotonic() < began + PATIENCE_S

    def test_destroyed_entity_leaves_graph_at_wait_or_shutdown(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        subscriptions = [node.create_subscription(Empty, f'topic{n}', print, 1) for n in (1, 2)]
        executor.add_node(node)
        for number, subscription in enumerate(subscriptions, start=1):
            there = partial(node.count_subscribers, f'topic{number}')
            spin_once(executor, 0.0)
            node.destroy_subscription(subscription)
            assert there() == 1  # it is being waited for
            if number == 1:
                spin_once(executor, 0.0)
            else:
                executor.shutdown()
            assert there() == 0

    def test_task_from_task_runs_before_next_wait(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        seen: list[int] = []
        counter = WaitCounter(node)
        executor.add_node(node)
        spin_until(executor, lambda: counter.waits, 'the entities')

        def call() -> None:
            waits = counter.waits
            executor.create_task(lambda: seen.append(counter.waits - waits))

        executor.create_task(call)
        spin_until(executor, lambda: seen, 'the task')
        assert seen == [0]

    def test_executor_waits_only_for_existing_entities(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        executor.add_node(node)
        called: list[str] = []
        first = node.create_timer(0.01, lambda: called.append('first'))
        spin_until(executor, lambda: called, 'the first timer')
        node.destroy_timer(first)
        node.create_timer(0.01, lambda: called.append('second'))
        called.clear()
        spin_until(executor, lambda: len(called) > 2, 'the second timer')
        assert set(called) == {'second'}

    def test_timer_that_adds_entities_does_not_starve_others(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        calls: list[int] = []
        served: list[int] = []

        def call() -> None:
            calls.append(1)
            node.create_timer(PATIENCE_S, print)

        always = node.create_timer(1e-9, call)
        timer = node.create_timer(0.01, lambda: served.append(len(calls)))
        executor.add_node(node)
        wait_until_ready(always, timer)
        for _ in range(10):
            spin_once(executor, 0.0)
        assert served
        assert served[0] == 1

    def test_timer_destroyed_while_ready_does_not_run(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        called: list[Any] = []
        timers: list[Any] = []

        def only_one() -> None:
            called.append(1)
            node.destroy_timer(timers[1])
            timers[0].cancel()

        timers += [node.create_timer(0.01, only_one), node.create_timer(0.01, only_one)]
        node.create_timer(0.1, lambda: called.append('later'))
        executor.add_node(node)
        wait_until_ready(*timers)
        spin_until(executor, lambda: 'later' in called, 'the last timer')
        assert called == [1, 'later']

    def test_awaiting_callback_blocks_its_group_without_spinning(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        future: Future[str] = Future(executor=executor)
        called: list[str] = []
        other = MutuallyExclusiveCallbackGroup()
        counter = WaitCounter(node, other)

        async def wait_long() -> None:
            first.cancel()
            called.append('begins')
            called.append(await future or '')

        def end_it() -> None:
            called.append('others')
            if called.count('others') == 3:
                future.set_result('ends')

        wait: Any = wait_long
        first = node.create_timer(0.01, wait)
        node.create_timer(0.02, lambda: called.append('same group'))
        node.create_timer(0.1, end_it, callback_group=other)
        executor.add_node(node)
        spin_until(executor, lambda: called[-1:] == ['same group'], 'the group to be free')
        assert called == ['begins', 'others', 'others', 'others', 'ends', 'same group']
        assert counter.waits < 10

    def test_guard_condition_runs_once_per_trigger(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        called: list[int] = []
        guard = node.create_guard_condition(lambda: called.append(1))
        executor.add_node(node)
        for times in (1, 2):
            guard.trigger()
            spin_until(executor, lambda: len(called) >= times, 'the guard')  # noqa: B023
            spin_once(executor, 0.02)
            assert len(called) == times

    def test_guard_trigger_survives_entity_changes(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        called: list[int] = []
        guard = node.create_guard_condition(lambda: called.append(1))

        def change() -> None:
            timer.cancel()
            node.create_timer(100.0, called.clear)

        timer = node.create_timer(0.01, change)
        executor.add_node(node)
        wait_until_ready(timer)
        guard.trigger()
        spin_until(executor, lambda: called, 'the guard')

    def test_gives_up_in_time(self, executor: LeanExecutor, node: Node) -> None:
        executor.add_node(node)
        spin_once(executor, 0.0)
        began = time.monotonic()
        spin_once(executor, 0.2)
        assert 0.2 <= time.monotonic() - began < PATIENCE_S

    def test_a_future_ends_its_spinning(self, executor: LeanExecutor, node: Node) -> None:
        executor.add_node(node)
        future: Future[int] = Future()
        thread = threading.Timer(0.2, lambda: future.set_result(1))
        thread.start()
        began = time.monotonic()
        executor.spin_until_future_complete(future, timeout_sec=PATIENCE_S)
        thread.join()
        assert future.done()
        assert time.monotonic() < began + PATIENCE_S

    def test_a_task_made_between_spins_is_run(self, executor: LeanExecutor, node: Node) -> None:
        executor.add_node(node)
        spin_once(executor, 0.0)
        done: list[int] = []
        executor.create_task(lambda: done.append(1))
        spin_until(executor, lambda: done, 'the task')


def test_quiet_node_without_event_handlers_can_be_destroyed(context: Context) -> None:
    node = Node('quiet', context=context)
    assert list(node.waitables), 'rclpy makes none any more: there is nothing to take away'
    quieten(node)
    assert list(node.waitables) == []
    node.destroy_node()


class TestServices:
    """They are waited for in a thread of their own, and called back in the executor's."""

    @pytest.fixture
    def executor(self, context: Context, node: Node) -> Iterator[LeanExecutor]:
        executor = LeanExecutor(context=context)
        executor.add_node(node)
        yield executor
        executor.shutdown()

    @pytest.fixture
    def client(self, node: Node) -> LeanQuestions:
        client = LeanQuestions(node, Service(CancelGoal, 'cancel'))
        PartedWaitable(node, node.get_logger(), [client])
        return client

    @pytest.fixture
    def served(self, executor: LeanExecutor, node: Node, client: LeanQuestions) -> LeanQuestions:
        """Give the client of a service that answers at once."""
        node.create_service(CancelGoal, 'cancel', lambda _, response: response)
        spin_until(executor, client.is_served, 'the service')
        return client

    def test_executor_thread_answers_each_request_once(
        self, executor: LeanExecutor, node: Node, client: LeanQuestions
    ) -> None:
        called: list[bool] = []
        answers: list[Any] = []
        here = threading.current_thread()

        def answer(_: Any, response: Any) -> Any:
            called.append(threading.current_thread() is here)
            return response

        node.create_service(CancelGoal, 'cancel', answer)
        spin_until(executor, client.is_served, 'the service')
        for burst in (1, 7, 2):
            before = len(answers)
            for _ in range(burst):
                client.ask(CancelGoal.Request(), answers.append)
            spin_until(executor, lambda: len(answers) == before + burst, 'the answers')  # noqa: B023
        assert called == [True] * 10

    def test_requests_are_answered_despite_long_timer_callbacks(
        self, executor: LeanExecutor, node: Node, served: LeanQuestions
    ) -> None:
        answers: list[Any] = []
        node.create_timer(1e-9, lambda: time.sleep(0.02))  # a long turn
        for number in range(1, 6):
            served.ask(CancelGoal.Request(), answers.append)
            spin_until(executor, lambda: len(answers) == number, 'the answer')  # noqa: B023

    def test_without_requests_nobody_looks_at_them(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        counter = WaitCounter(node)
        node.create_service(CancelGoal, 'cancel', print)
        spin_once(executor, 0.3)
        assert counter.waits <= 2
        assert SERVICE not in {member.kind for member in executor._wait_list._members}

    def test_awaiting_service_blocks_its_group_without_spinning(
        self, executor: LeanExecutor, node: Node, client: LeanQuestions
    ) -> None:
        future: Future[None] = Future(executor=executor)
        began: list[int] = []
        answers: list[Any] = []
        counter = WaitCounter(node, MutuallyExclusiveCallbackGroup())

        async def answer(_: Any, response: Any) -> Any:
            began.append(1)
            await future
            return response

        callback: Any = answer
        group = MutuallyExclusiveCallbackGroup()
        node.create_service(CancelGoal, 'cancel', callback, callback_group=group)
        spin_until(executor, client.is_served, 'the service')
        client.ask(CancelGoal.Request(), answers.append)
        spin_until(executor, lambda: began, 'the first request')
        client.ask(CancelGoal.Request(), answers.append)
        waits, until = counter.waits, time.monotonic() + 0.3
        while time.monotonic() < until:
            spin_once(executor, 0.1)
        assert (len(began), answers) == (1, [])
        assert counter.waits - waits < 10
        future.set_result(None)
        spin_until(executor, lambda: len(answers) == 2, 'both answers')

    def test_service_answers_while_entities_keep_changing(
        self, executor: LeanExecutor, node: Node, served: LeanQuestions
    ) -> None:
        answers: list[Any] = []

        def call() -> None:
            node.create_timer(PATIENCE_S, print)

        node.create_timer(1e-9, call)
        served.ask(CancelGoal.Request(), answers.append)
        spin_until(executor, lambda: answers, 'the answer')

    def test_destroyed_service_leaves_graph_at_next_wait(
        self, executor: LeanExecutor, node: Node
    ) -> None:
        service = node.create_service(CancelGoal, 'cancel', print)
        spin_once(executor, 0.0)
        node.destroy_service(service)
        assert node.count_services('cancel') == 1  # it is being waited for
        spin_once(executor, 0.0)
        assert node.count_services('cancel') == 0

    @pytest.mark.parametrize('context_first', [True, False])
    def test_their_thread_ends_with_the_executor(
        self, context: Context, node: Node, *, context_first: bool
    ) -> None:
        before = set(threading.enumerate())  # those of earlier tests may end at any time
        executor = LeanExecutor(context=context)
        executor.add_node(node)
        spin_once(executor, 0.0)
        (serving,) = set(threading.enumerate()) - before
        if context_first:
            context.try_shutdown()
        executor.shutdown()
        assert not serving.is_alive()


def test_client_is_waited_for_only_while_awaiting_answer(context: Context, node: Node) -> None:
    """A node has many, most of which await nothing; the middleware looks at each in each wait."""
    asked: list[Any] = []

    def answer(request: Any, response: Any) -> Any:
        asked.append(request)
        return response

    node.create_service(CancelGoal, 'cancel', answer)
    client = LeanQuestions(node, Service(CancelGoal, 'cancel'))
    waitable = CountedRuns(node, node.get_logger(), [client])
    executor = LeanExecutor(context=context)
    executor.add_node(node)
    spin_until(executor, client.is_served, 'the service')
    client.tell(CancelGoal.Request())
    spin_until(executor, lambda: asked, 'the request')
    spin_once(executor, 0.3)  # the answer comes, and wakes nobody
    assert waitable.runs == 0
    answers: list[Any] = []
    client.ask(CancelGoal.Request(), answers.append)
    spin_until(executor, lambda: answers, 'the answer')
    assert len(answers) == 1
    executor.shutdown()


def test_soon_call_from_answer_runs_in_same_turn(context: Context, node: Node) -> None:
    node.create_service(CancelGoal, 'cancel', lambda _, response: response)
    client = LeanQuestions(node, Service(CancelGoal, 'cancel'))
    PartedWaitable(node, node.get_logger(), [client])
    counter = WaitCounter(node)
    executor = LeanExecutor(context=context)
    executor.add_node(node)
    turn, seen = 0, []

    def see(then: Callable[[], None] = lambda: None) -> None:
        seen.append((turn, counter.waits))
        then()

    def soon(call: Callable[[], None]) -> Callable[[], None]:
        return lambda: executor.soon(call)

    spin_until(executor, client.is_served, 'the service')
    client.ask(CancelGoal.Request(), lambda _: see(soon(lambda: see(soon(see)))))
    until = time.monotonic() + PATIENCE_S
    while len(seen) < 3 and time.monotonic() < until:
        turn += 1
        spin_once(executor, PATIENCE_S)
    executor.shutdown()
    answer, asked, further = seen
    assert asked == answer
    assert further == (answer[0] + 1, answer[1] + 1)


class CountedRuns(PartedWaitable):
    """Counts its turns in which something came that was asked for."""

    runs = 0

    def run(self) -> None:
        self.runs += 1
        super().run()


def test_events_executor_waits_and_keeps_its_timers(context: Context, node: Node) -> None:
    """Its own `spin` does neither in the wheels of Kilted."""
    events = pytest.importorskip('rclpy.experimental.events_executor')
    executor = events.EventsExecutor(context=context)
    called: list[float] = []
    node.create_timer(0.05, lambda: called.append(time.monotonic()))
    executor.add_node(node)
    used = time.process_time()
    began = time.monotonic()
    spin_until(executor, lambda: len(called) >= 20, 'the timer')
    assert time.process_time() - used < 0.5 * (time.monotonic() - began)
    executor.shutdown()
