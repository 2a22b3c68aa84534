"""What-if of a running cell, worked out in a process of low priority.

The blackboard of py_trees is global to a process, and a virtual run takes the interpreter for
itself: neither is for a process that serves somebody meanwhile.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.child_process import ChildFailed, ChildProcess, be_modest, serve
from bt_orchestrator.errors import NotKept
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.ports import Consequence, Moment

NICE = 19
"""Lowest priority: whatever the cell needs comes first."""

WITHIN_S = 60.0
"""Longest time for an answer; the runs themselves give up earlier."""


class WhatIfProcess:
    """Asks the process. Implements `ports.WhatIf`."""

    def __init__(self, moment: Moment, trees: Sequence[Path] = ()) -> None:
        """Begin from a moment.

        :param trees: folders in which the scripts of new orders are looked up
        """
        self._process = ChildProcess(__name__, pickle.dumps((moment, tuple(trees))))

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        :raises NotKept: the moment cannot be gone on from
        """
        try:
            answer = pickle.loads(self._process.ask(pickle.dumps(tuple(requests)), WITHIN_S))
        except ChildFailed as error:
            raise NotKept(f'nothing could be worked out: {error}') from error
        if isinstance(answer, Consequence):
            return answer
        raise NotKept(f'nothing could be worked out: {answer}')

    def close(self) -> None:
        """End the process."""
        self._process.close()


class _Answers:
    """What the process knows: the moment of the first question."""

    def __init__(self) -> None:
        self._setup: tuple[Moment, tuple[Path, ...]] | None = None

    def __call__(self, question: bytes) -> bytes:
        asked = pickle.loads(question)
        if self._setup is None:
            self._setup = asked
            return b''
        try:
            return pickle.dumps(self._answer(asked))
        except Exception as error:  # noqa: BLE001 - told to whoever asks
            return pickle.dumps(repr(error))

    def _answer(self, requests: Sequence[Asked]) -> Consequence:
        from bt_orchestrator.ros.types.action_types import InstalledActionTypes
        from bt_orchestrator.sim.what_if import EngineWhatIf

        assert self._setup is not None
        moment, trees = self._setup
        return EngineWhatIf(moment, InstalledActionTypes(), trees).ask(requests)


def main() -> None:
    """Answer until nobody is left to hear it."""
    be_modest(NICE)
    serve(_Answers())


if __name__ == '__main__':
    main()
