"""Kill a cell's orchestrator and controllers many times, and say what that did.

python -m chaos [--database | --standby | --client plain] [--kills N] [--items N] [--seed N]
    [--keep FOLDER]

With --database the journal is in PostgreSQL: a server with a synchronous replica, which this
program makes, cuts off, restarts, ends as a crash does and replaces. Then each trap of such a
database is sprung, with the check that is against it and without.

With --standby there are two nodes of the cell. The leader is killed, or stopped and let go on
later; each time the other one has to go on.

With --client plain the nodes use nothing of rclpy's inside.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import interrupts
from chaos import plan
from chaos.campaign import Campaign
from chaos.tally import Tally, lines
from ros_domain import OwnDomain

ITEMS = 20
KILLS_A_JOB = 20


def main() -> int:
    """Run the campaign; 0 when nothing was lost, done twice or stuck, and no reader misled."""
    args = _arguments()
    interrupts.heed()
    with OwnDomain(), tempfile.TemporaryDirectory(prefix='chaos_') as scratch:
        folder = (args.keep or Path(scratch)).resolve()
        drawn = random.Random(args.seed)
        if args.standby:
            from chaos import standby

            stops = args.kills // 2
            campaign = standby.Succession(folder, args.seed, args.items, args.kills, stops)
            counts = campaign.run()
            print('\n'.join(counts.lines()), flush=True)
            return 1 if counts.verdict.faults else 0
        if not args.database:
            shots = list(plan.draw(drawn, args.kills))
            make = partial(Campaign, run_options=['--client', args.client])
            return _report(_campaigns(folder, drawn, args.items, shots, make))
        strikes = {name: args.kills // share for name, share in _ONE_IN.items()}
        shots = list(plan.draw_with_database(drawn, args.kills, args.kills // 2, strikes))
        total = _campaigns(folder, drawn, args.items, shots, _on_a_database)
        return _report(total) + _spring_traps(folder, max(args.kills // 10, 1))


_ONE_IN = {
    'cut': 5,
    'restart': 5,
    'crash': 5,
    'lost_answer': 1,
    'lost_commit': 5,
    'promotion': 10,
}
"""Kills for one such strike at the database."""

_WITHOUT = 3
"""Rounds of each trap without its check."""


def _campaigns(
    folder: Path,
    drawn: random.Random,
    items: int,
    shots: Sequence[plan.Shot],
    make: Callable[[Path, int, int, Sequence[plan.Shot]], Campaign],
) -> Tally:
    total = Tally()
    for number, part in enumerate(plan.parts(shots, KILLS_A_JOB), 1):
        here = folder / f'part_{number}'
        here.mkdir(parents=True)
        tally = make(here, drawn.randrange(1 << 32), items, part).run()
        total.add(tally)
        kills, faults = total.orchestrator_kills, total.verdict.faults
        print(f'part {number}: {kills} kills, {len(faults)} faults', flush=True)
        print(*tally.faults, sep='\n', end='\n' * bool(tally.faults), flush=True)
    return total


def _report(total: Tally) -> int:
    print('\n'.join(lines(total)), flush=True)
    return 1 if total.faults else 0


def _on_a_database(folder: Path, seed: int, items: int, shots: Sequence[plan.Shot]) -> Campaign:
    from chaos.database import Database

    return Campaign(folder, seed, items, shots, Database())


def _spring_traps(folder: Path, number: int) -> int:
    """Spring each trap with its check and without; 0: it loses events without it alone."""
    from chaos import traps

    failed = 0
    for trap in traps.TRAPS:
        lost = traps.rounds(folder, trap, number, checked=True)
        seen = traps.rounds(folder, trap, _WITHOUT, checked=False)
        print(
            f'{trap.name}: events lost in {sum(map(bool, lost))} of {number} rounds with its '
            f'check, in {sum(map(bool, seen))} of {_WITHOUT} without',
            flush=True,
        )
        for fault in (fault for faults in lost for fault in faults):
            print(f'  {fault}')
        failed += any(lost) or not all(seen)
    return failed


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/chaos', description=__doc__.splitlines()[0])
    parser.add_argument('--kills', type=int, default=200, help='of the orchestrator (default 200)')
    parser.add_argument(
        '--database', action='store_true', help='the journal is in PostgreSQL, with a replica'
    )
    parser.add_argument(
        '--standby', action='store_true', help='a standby goes on; half as many are stopped'
    )
    parser.add_argument(
        '--client', choices=('auto', 'plain'), default='auto', help='of each node (default auto)'
    )
    parser.add_argument('--items', type=int, default=ITEMS, help='of each order (default 20)')
    parser.add_argument('--seed', type=int, default=1, help='of every draw (default 1)')
    parser.add_argument('--keep', type=Path, metavar='FOLDER', help='keep journals and logs there')
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
