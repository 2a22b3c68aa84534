"""An operator of a drawn line, who sees the cell as a bench shows it, and does what was drawn."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Protocol

from fakes.drawn.plan import Moment

PATIENCE = 120
"""Decisions after which an operator has had enough: no drawn line needs nearly as many."""


class Bench(Protocol):
    """What an operator sees and does, of either cell."""

    @property
    def live(self) -> bool: ...
    @property
    def paused(self) -> bool: ...
    def wait(self, seconds: float | None) -> None: ...
    def holds(self) -> list[tuple[str, Sequence[str], str | None]]: ...
    def standing(self) -> list[str]: ...
    def answer(self, hold: str, answer: str) -> None: ...
    def remove(self, item: str) -> None: ...
    def pause(self, paused: bool) -> None: ...
    def commands(self) -> Sequence[str]:
        """Return the commands to the cell that are possible now, but for pauses."""

    def command(self, what: str) -> None: ...
    def components(self) -> Sequence[str]: ...
    def out_of_service(self) -> Sequence[str]: ...
    def service(self, component: str) -> None:
        """Take a component out of service, or bring it back."""

    def unreleased(self) -> Sequence[str]:
        """Return the names of scripts that jobs of the queue wait for."""

    def release(self, script: str) -> None: ...
    def possible(self) -> list[tuple[str, str]]:
        """Return what can be asked of each job now, job after job."""

    def ask(self, what: str, job: str, number: int) -> None: ...
    def ways_to_empty(self) -> Sequence[str]: ...
    def run_empty(self, after: str) -> None: ...
    def free(self) -> list[str]:
        """Return the jobs of the queue whose places nobody chose, in order."""

    def arrange(self, jobs: Sequence[str]) -> None:
        """Put these jobs into another order, at the places that they have together."""

    def telling(self) -> Sequence[str]:
        """Return the components whose state topics tell what they are set up for."""

    def set_up(self, component: str, value: str) -> None:
        """Set a component up by hand, which its state topic tells."""

    def order(self) -> bool:
        """Give the next order; return False if none is left."""


REMOVES, PAUSES, ORDERS = 7, 8, 9
GOES_ON = ('clear', 'reset', 'start')
COMMANDS_OF = {10: ('stop',), 11: GOES_ON, 12: ('abort',)}
"""Choices of an operator who does more than answer."""
RELEASES = 15
RUNS_EMPTY = 26
ARRANGES = 27
SETS_UP = 28
OF_JOBS = range(16, 26)
"""Choices of one who asks something of a job."""
SERVICE = (13, 14)
"""Choices of one who takes a component out of service, or brings it back."""


def operate(bench: Bench, moments: Sequence[Moment]) -> bool:
    """Work until every job ended; return False if the line got stuck.

    At last everything is answered, resumed and started, and every order given.
    """
    later = itertools.repeat(None, PATIENCE)
    for moment in itertools.chain(moments, later):
        bench.wait(moment.delay_s if moment else None)
        if not bench.live and moment is None:
            if not bench.order():
                return True
            continue
        choice = moment.choice if moment else 1
        if choice == ORDERS:
            bench.order()
        elif choice in SERVICE:
            names = bench.components()
            which = choice + (int(moment.delay_s) if moment else 0)
            bench.service(names[which % len(names)])
        elif moment and choice == SETS_UP and (telling := bench.telling()):
            number = int(moment.delay_s * 10)
            bench.set_up(telling[number % len(telling)], 'xyz'[number % 3])
        elif choice in OF_JOBS and (possible := bench.possible()):
            number = choice - OF_JOBS.start + (int(moment.delay_s) if moment else 0)
            which = (number * 7 + len(possible) // 2) % len(possible)
            bench.ask(*possible[which], number)
        elif choice == RUNS_EMPTY and (ways := bench.ways_to_empty()):
            bench.run_empty(ways[int(moment.delay_s if moment else 0) % len(ways)])
        elif moment and choice == ARRANGES and len(free := bench.free()) > 1:
            turn = 1 + int(moment.delay_s) % (len(free) - 1)
            bench.arrange([*free[turn:], *free[:turn]])
        elif moment is None and (kept := _kept(bench.possible())):
            bench.ask(*kept[0], 0)
        elif moment is None and (out := bench.out_of_service()):
            bench.service(out[0])
        elif (moment is None or choice == RELEASES) and (waited := bench.unreleased()):
            bench.release(waited[0])
        elif choice in COMMANDS_OF:
            _command(bench, COMMANDS_OF[choice])
        elif holds := bench.holds():
            hold, answers, item = holds[0]
            if 'remove_item' in answers:
                assert item is not None
                bench.remove(item)
            else:
                if moment is None:  # somebody has to let the job end
                    answers = [word for word in answers if word != 'again']
                if moment is None and 'change' in answers:
                    answers = ['change']
                bench.answer(hold, answers[choice % len(answers)])
        elif bench.paused:
            bench.pause(False)
        elif moment is None:
            if not _command(bench, GOES_ON):
                return False
        elif choice == REMOVES and (standing := bench.standing()):
            bench.remove(standing[choice % len(standing)])
        elif choice == PAUSES:
            bench.pause(True)
    raise AssertionError('an operator is asked again and again')


def _kept(possible: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return what lets jobs go on that somebody holds or has paused."""
    requests = [request for request in possible if request[0] in ('release', 'resume', 'another')]
    return sorted(requests, key=lambda request: request[0] == 'another')


def _command(bench: Bench, meant: Sequence[str]) -> bool:
    """Give one of these commands to the cell; tell whether one is possible."""
    fitting = [verb for verb in bench.commands() if verb in meant]
    for verb in fitting:
        bench.command(verb)
    return bool(fitting)
