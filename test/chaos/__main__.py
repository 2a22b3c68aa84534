"""Kill a cell's orchestrator and controllers many times, and say what that did.

python -m chaos [--kills N] [--items N] [--seed N] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
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
    total = Tally()
    with OwnDomain(), tempfile.TemporaryDirectory(prefix='chaos_') as scratch:
        folder = (args.keep or Path(scratch)).resolve()
        drawn = random.Random(args.seed)
        shots = list(plan.draw(drawn, args.kills))
        for number, part in enumerate(plan.parts(shots, KILLS_A_JOB), 1):
            here = folder / f'part_{number}'
            here.mkdir(parents=True)
            total.add(Campaign(here, drawn.randrange(1 << 32), args.items, part).run())
            kills, faults = total.orchestrator_kills, total.verdict.faults
            print(f'part {number}: {kills} kills, {len(faults)} faults', flush=True)
    print('\n'.join(lines(total)))
    return 1 if total.faults else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/chaos', description=__doc__.splitlines()[0])
    parser.add_argument('--kills', type=int, default=200, help='of the orchestrator (default 200)')
    parser.add_argument('--items', type=int, default=ITEMS, help='of each order (default 20)')
    parser.add_argument('--seed', type=int, default=1, help='of every draw (default 1)')
    parser.add_argument('--keep', type=Path, metavar='FOLDER', help='keep journals and logs there')
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
