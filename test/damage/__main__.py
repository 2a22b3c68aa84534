"""Damage journals at random, and see that a node forgets nothing without a word.

python -m damage [--cases N] [--seed N] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from collections import Counter
from pathlib import Path

from damage.judge import Verdict, judge
from damage.kinds import KINDS, draw
from damage.scene import make_scenes

BAD = (Verdict.SILENT, Verdict.FAULT)


def main() -> int:
    """Judge the cases; 0 when none was silent or a fault."""
    args = _arguments()
    logging.disable(logging.CRITICAL)
    counts: Counter[tuple[str, Verdict]] = Counter()
    with tempfile.TemporaryDirectory(prefix='damage_') as scratch:
        folder = (args.keep or Path(scratch)).resolve()
        for case in draw(make_scenes(folder), args.cases):
            judgement = judge(case, folder / f'case_{case.number}', args.seed)
            counts[case.kind, judgement.verdict] += 1
            if judgement.verdict in BAD or args.all:
                print(f'{case.words}: {judgement.verdict.value}: {judgement.said}', flush=True)
    for kind in KINDS:
        print(f'{kind:<6}', _listed(Counter({v: counts[kind, v] for v in Verdict})))
    total = Counter({v: sum(counts[kind, v] for kind in KINDS) for v in Verdict})
    print('all   ', _listed(total))
    return 1 if any(total[bad] for bad in BAD) else 0


def _listed(counter: Counter[Verdict]) -> str:
    return ', '.join(f'{verdict.value} {counter[verdict]}' for verdict in Verdict)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/damage', description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=int, default=400, help='damages (default 400)')
    parser.add_argument('--seed', type=int, default=1, help='of every draw (default 1)')
    parser.add_argument('--all', action='store_true', help='print every case, not only bad ones')
    parser.add_argument('--keep', type=Path, metavar='FOLDER', help='keep the journals there')
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
