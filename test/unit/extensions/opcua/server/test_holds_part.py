"""When conditions begin, change and end, without a server."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from asyncua import ua
from fakes.statuses import NOW_S, hold, status

from bt_orchestrator.extensions.opcua.server.conditions import Place
from bt_orchestrator.extensions.opcua.server.holds import Holds
from bt_orchestrator.extensions.opcua.server.notices import Told
from bt_orchestrator.extensions.opcua.server.values import moment
from bt_orchestrator.model.events import HoldReleased, OperatorDecided, StopReasonChanged
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.stop_reason import StopReason


class Scene:
    """The part, and what it tells."""

    def __init__(self) -> None:
        self.told: list[Told] = []
        bridge: Any = SimpleNamespace(history='a', status=status())
        self.part = Holds(bridge)
        self.part._bridge = bridge
        self.part._notices = self  # type: ignore[assignment]
        self.part._place = Place(ua.NodeId('T', 4), 4, ua.NodeId('cell', 4), 'cell')

    def tell(self, told: Told, *nodes: ua.NodeId) -> None:
        """As `Notices`."""
        self.told.append(told)

    def show(self, *holds: Hold) -> CellStatus:
        """Show a status with these holds."""
        shown = status(holds=[*holds])
        self.part.show(shown)
        return shown

    def take(self) -> list[tuple[bool, bool, str]]:
        """Return whether each told condition is active, acknowledged, and its last remark."""
        found = [
            (
                one.fields['ActiveState/Id'].Value,
                one.fields['AckedState/Id'].Value,
                one.fields['Comment'].Value.Text,
            )
            for one in self.told
        ]
        self.told.clear()
        return found


def decided(answer: str, reason: str = 'because') -> OperatorDecided:
    return OperatorDecided(
        answer=answer, who='Ben', reason=reason, known='page login', hold='1', time=NOW_S
    )


def test_a_hold_tells_the_words_and_the_feedback_of_the_controller_apart() -> None:
    scene = Scene()
    feedback = '{"current_sub_task": "GRIP"}'
    scene.show(replace(hold('1'), controller_said='the tip is dry', last_feedback=feedback))
    (one,) = scene.told
    fields = {name: one.fields[name].Value for name in ('ControllerSaid', 'LastFeedback')}
    assert fields == {'ControllerSaid': 'the tip is dry', 'LastFeedback': feedback}


def test_an_answer_is_the_last_remark_of_a_hold() -> None:
    scene = Scene()
    scene.show(hold())
    scene.show(hold())
    assert scene.take() == [(True, False, '')]
    scene.part.hear(decided('retry'))
    scene.part.hear(HoldReleased(hold='1', time=NOW_S))
    scene.show()
    assert [one.time for one in scene.told] == [NOW_S]
    assert scene.take() == [(False, True, 'retry: because')]


def test_who_resumes_a_pause_or_removes_an_item_has_ended_its_hold() -> None:
    scene = Scene()
    scene.show(hold(), hold('2'))
    scene.take()
    scene.part.hear(OperatorDecided(answer='resume', who='Ben', reason='tea', time=NOW_S))
    scene.part.hear(HoldReleased(hold='2', time=NOW_S))
    scene.part.hear(HoldReleased(hold='1', time=NOW_S + 1))
    scene.show()
    assert scene.take() == [(False, True, ''), (False, True, 'resume: tea')]


def test_who_clears_has_ended_the_emergency() -> None:
    scene = Scene()
    scene.part.hear(StopReasonChanged(stop_reason='', time=NOW_S - 9))  # of before
    scene.part.show(status(stop_reason=StopReason.EMERGENCY))
    assert scene.take() == [(True, False, '')]
    scene.part.hear(OperatorDecided(answer='clear', who='Ben', reason='looked', time=NOW_S))
    scene.part.hear(StopReasonChanged(stop_reason='', time=NOW_S))
    scene.show()
    assert [one.time for one in scene.told] == [NOW_S]
    assert scene.take() == [(False, True, 'clear: looked')]


def test_a_status_that_comes_before_its_events_waits_for_them() -> None:
    scene = Scene()
    scene.show(hold())
    scene.take()
    scene.show()
    assert scene.take() == []
    scene.part.hear(decided('skip'))
    assert scene.take() == []
    scene.part.hear(HoldReleased(hold='1', time=NOW_S))
    assert scene.take() == [(False, True, 'skip: because')]
    scene.show()
    assert scene.take() == []


def test_an_end_that_no_event_tells_of_counts_with_the_next_status() -> None:
    scene = Scene()
    scene.show(hold())
    scene.show()
    scene.take()
    scene.show()
    assert scene.take() == [(False, True, '')]


def test_remarks_from_anywhere_are_shown() -> None:
    scene = Scene()
    scene.show(hold())
    scene.take()
    scene.part.hear(decided('comment', 'who has the key?'))
    scene.part.hear(decided('acknowledge', 'on my way'))
    scene.show(hold())
    assert scene.take() == [(True, False, 'who has the key?'), (True, True, 'on my way')]


def test_other_answers_are_told_and_what_was_acknowledged_stays_so() -> None:
    scene = Scene()
    scene.show(hold())
    scene.part.hear(decided('acknowledge'))
    scene.take()
    scene.show(hold(answers=('retry', 'abort_job')))
    (told,) = scene.told
    assert told.fields['Answers'].Value == ['retry', 'abort_job']
    assert told.fields['AnswerRoles'].Value == ['operate or engineer', 'engineer']
    assert scene.take() == [(True, True, 'because')]


def test_with_another_journal_all_conditions_end_and_numbers_begin_anew() -> None:
    scene = Scene()
    scene.show(hold())
    first = scene.told[0].id
    scene.part.hear(decided('acknowledge'))
    scene.take()
    scene.part.begin('b')
    assert [active for active, _, _ in scene.take()] == [False]
    scene.show(hold())
    assert scene.told[0].id != first
    assert scene.take() == [(True, False, '')]


def test_a_step_of_the_clock_moves_the_begin_of_a_hold_and_keeps_remarks() -> None:
    scene = Scene()
    scene.show(hold(since=NOW_S))
    scene.part.hear(decided('acknowledge'))
    scene.take()
    scene.show(hold(since=NOW_S - 3600.0))
    (told,) = scene.told
    assert told.fields['ActiveState/TransitionTime'].Value == moment(NOW_S - 3600.0)
    assert scene.take() == [(True, True, 'because')]


def test_an_abort_after_a_clear_that_no_status_told_is_another_emergency() -> None:
    scene = Scene()
    emergency = status(stop_reason=StopReason.EMERGENCY)
    scene.part.show(emergency)
    scene.take()
    scene.part.hear(StopReasonChanged(stop_reason='', time=NOW_S, seq=emergency.seq + 1))
    scene.part.show(emergency)
    assert scene.take() == []
    scene.part.show(replace(emergency, seq=emergency.seq + 2))
    assert scene.take() == [(True, False, '')]
