"""Kill a cell's orchestrator and controllers many times, and say what that did.

python -m chaos [--kills N] [--items N] [--seed N] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from chaos.campaign import BOTH, SHARES, Campaign, Tally
from chaos.crashing_node import POINTS
from ros_domain import OwnDomain

ITEMS = 20
KILLS_A_JOB = 20

_CONTROLLERS_EVERY = 5
"""One kill in so many is of controllers, on top of those of the orchestrator."""

_WITH_CONTROLLERS = (*SHARES, BOTH, BOTH)
"""What such a kill is of, each as likely."""

_AT_RANDOM = 3
"""Random moments among the crash points, so often as each of them."""


def main() -> int:
    """Run the campaign; 0 when nothing was lost, done twice or stuck."""
    args = _arguments()
    total = Tally()
    with OwnDomain(), tempfile.TemporaryDirectory(prefix='chaos_') as scratch:
        folder = args.keep or Path(scratch)
        drawn = random.Random(args.seed)
        job = 0
        while total.orchestrator_kills < args.kills:
            job += 1
            here = folder / f'job_{job}'
            here.mkdir(parents=True)
            plan = list(targets(drawn, min(KILLS_A_JOB, args.kills - total.orchestrator_kills)))
            total.add(Campaign(here, drawn.randrange(1 << 32), args.items, plan).run())
            print(
                f'job {job}: {total.orchestrator_kills} kills, {len(total.verdict.faults)} faults'
            )
    print('\n'.join(lines(total)))
    return 1 if total.verdict.faults else 0


def targets(drawn: random.Random, kills: int) -> Iterator[str]:
    """Yield what is killed, in order: so many orchestrators, and controllers between."""
    among = [*POINTS, *['orchestrator'] * _AT_RANDOM]
    bag: list[str] = []
    for number in range(1, kills + 1):
        if not bag:
            bag = drawn.sample(among, len(among))
        yield bag.pop()
        if number % _CONTROLLERS_EVERY == 0:
            yield drawn.choice(_WITH_CONTROLLERS)


def lines(total: Tally) -> Iterator[str]:
    """Yield the figures, and every fault."""
    by_name = ', '.join(f'{name} {count}' for name, count in sorted(total.kills.items()))
    yield f'{total.items} items, {total.seconds:.0f} s; kills: {by_name}'
    kills = total.orchestrator_kills
    share = total.with_goals / kills if kills else 0.0
    yield f'{kills} kills of the orchestrator, {share:.0%} of them while a goal ran'
    yield (
        f'{total.adopted} goals adopted, {total.resent} sent again with their UUID, '
        f'{total.in_doubt} in doubt, {total.server_lost} lost with their server; answers: '
        + (', '.join(f'{name} {count}' for name, count in total.answers.items()) or 'none')
    )
    verdict = total.verdict
    yield (
        f'lost {len(verdict.lost)}, twice {len(verdict.twice)}, stuck {len(verdict.stuck)}, '
        f'journal untrue {len(verdict.untrue)}, needlessly in doubt {len(verdict.needless_doubt)}'
    )
    yield from verdict.faults


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/chaos', description=__doc__.splitlines()[0])
    parser.add_argument('--kills', type=int, default=200, help='of the orchestrator (default 200)')
    parser.add_argument('--items', type=int, default=ITEMS, help='of each job (default 20)')
    parser.add_argument('--seed', type=int, default=1, help='of every draw (default 1)')
    parser.add_argument('--keep', type=Path, metavar='FOLDER', help='keep journals and logs there')
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
