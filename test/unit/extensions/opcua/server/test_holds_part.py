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

    def tell(self, message: Told, *nodes: ua.NodeId) -> None:
        """As `Notices`."""
        self.told.append(message)

    def show(self, *holds: Hold) -> CellStatus:
        """Show a status with these holds."""
        shown = status(holds=[*holds])
        self.part.show(shown)
        return shown

    def take(self) -> list[tuple[bool, bool, str]]:
        """Return whether each told condition is active, acknowledged, and its last remark."""
        states = [
            (
                condition.fields['ActiveState/Id'].Value,
                condition.fields['AckedState/Id'].Value,
                condition.fields['Comment'].Value.Text,
            )
            for condition in self.told
        ]
        self.told.clear()
        return states


def decided(answer: str, reason: str = 'because') -> OperatorDecided:
    return OperatorDecided(
        answer=answer, who='Ben', reason=reason, known='page login', hold='1', time=NOW_S
    )


def test_hold_separates_controller_words_from_feedback() -> None:
    scene = Scene()
    feedback = '{"current_sub_task": "GRIP"}'
    scene.show(replace(hold('1'), controller_said='the tip is dry', last_feedback=feedback))
    (condition,) = scene.told
    fields = {name: condition.fields[name].Value for name in ('ControllerSaid', 'LastFeedback')}
    assert fields == {'ControllerSaid': 'the tip is dry', 'LastFeedback': feedback}


def test_answer_becomes_last_remark_of_hold() -> None:
    scene = Scene()
    scene.show(hold())
    scene.show(hold())
    assert scene.take() == [(True, False, '')]
    scene.part.hear(decided('retry'))
    scene.part.hear(HoldReleased(hold='1', time=NOW_S))
    scene.show()
    assert [condition.time for condition in scene.told] == [NOW_S]
    assert scene.take() == [(False, True, 'retry: because')]


def test_resume_or_item_removal_ends_its_hold() -> None:
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
    assert [condition.time for condition in scene.told] == [NOW_S]
    assert scene.take() == [(False, True, 'clear: looked')]


def test_early_status_waits_for_its_events() -> None:
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


def test_unannounced_end_takes_effect_with_next_status() -> None:
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


def test_new_answers_are_reported_and_acknowledgement_stays() -> None:
    scene = Scene()
    scene.show(hold())
    scene.part.hear(decided('acknowledge'))
    scene.take()
    scene.show(hold(answers=('retry', 'abort_job')))
    (condition,) = scene.told
    assert condition.fields['Answers'].Value == ['retry', 'abort_job']
    assert condition.fields['AnswerRoles'].Value == ['operate or engineer', 'engineer']
    assert scene.take() == [(True, True, 'because')]


def test_new_journal_ends_conditions_and_restarts_numbers() -> None:
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


def test_clock_step_moves_hold_start_and_keeps_remarks() -> None:
    scene = Scene()
    scene.show(hold(since=NOW_S))
    scene.part.hear(decided('acknowledge'))
    scene.take()
    scene.show(hold(since=NOW_S - 3600.0))
    (condition,) = scene.told
    assert condition.fields['ActiveState/TransitionTime'].Value == moment(NOW_S - 3600.0)
    assert scene.take() == [(True, True, 'because')]


def test_abort_after_unreported_clear_is_new_emergency() -> None:
    scene = Scene()
    emergency = status(stop_reason=StopReason.EMERGENCY)
    scene.part.show(emergency)
    scene.take()
    scene.part.hear(StopReasonChanged(stop_reason='', time=NOW_S, seq=emergency.seq + 1))
    scene.part.show(emergency)
    assert scene.take() == []
    scene.part.show(replace(emergency, seq=emergency.seq + 2))
    assert scene.take() == [(True, False, '')]
