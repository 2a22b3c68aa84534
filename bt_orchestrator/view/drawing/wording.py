"""The words of a drawing, in the language of its reader."""

from __future__ import annotations

from bt_orchestrator.model.hold_words import hold_name, why_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.view.drawing.line_state import Mark


class Wording:
    """English, as it stands in the code; another language overrides everything.

    Names, arguments and what a device or a person said are no words: they stay as they are.
    """

    language = 'en'

    def report(self, words: str) -> str:
        """Say words, or a figure, of a report, which are in English."""
        return words

    def say(self, words: str, /, **values: object) -> str:
        """Return words of the drawing, with values in the places in braces."""
        return words.format(**values)

    def mark(self, mark: Mark) -> str:
        """Return the word of a mark."""
        return mark.word

    def state(self, state: PackmlState) -> str:
        """Name a state of the cell."""
        return state.value

    def job_state(self, state: str) -> str:
        """Name a state of a job.

        :param state: of ISA-95, with its substate behind a stroke
        """
        return state.partition('/')[0]

    def wait(self, wait: Wait) -> str:
        """Say what something waits for."""
        return wait.reason

    def message(self, message: str) -> str:
        """Say a message of the node, which is in English."""
        return message

    def condition(self, words: str) -> str:
        """Say a condition, which is in English; its names and values stay."""
        return words

    def failure(
        self, reason: str, message: str, controller_said: str = '', topic_says: str = ''
    ) -> str:
        """Say why something failed; see `why_words`."""
        return why_words(reason, message, controller_said, topic_says)

    def hold(self, hold: Hold) -> str:
        """Name a hold: its number, and why."""
        return hold_name(hold)

    def passed(self, reason: str) -> str:
        """Say why a task was skipped, or failed while the cycle goes on."""
        return reason

    def answer(self, word: str) -> str:
        """Name an answer to a hold."""
        return word


ENGLISH = Wording()
