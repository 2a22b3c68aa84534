"""Plan drawn lines, and hold each plan against CP-SAT.

python -m mixes [--mixes N] [--seed N] [--limit SECONDS]

A plan that is called proven has to be the fastest; every bound has to be one. Where CP-SAT proves
nothing within its limit, its own bounds count.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from typing import NoReturn

from mixes.drawn import Mix, mix
from mixes.exact import solve

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.model.script import Script


class NeverAsked:
    """Nothing is shared on these lines. Implements `planning.Judge`."""

    def pace_s(self, script: Script) -> NoReturn:
        """Refuse."""
        raise AssertionError(script.name)


def main() -> int:
    """Judge the mixes; 0 when every claim is true."""
    args = _arguments()
    seen: Counter[str] = Counter()
    for seed in range(args.seed, args.seed + args.mixes):
        _judge(mix(seed), args.limit, seen)
    print(', '.join(f'{name} {count}' for name, count in sorted(seen.items())))
    return 1 if seen['wrong'] else 0


def _judge(drawn: Mix, limit_s: float, seen: Counter[str]) -> None:
    began = time.perf_counter()
    claim = generate(drawn.cell, drawn.recipe, judge=NeverAsked()).claim
    took_s = time.perf_counter() - began
    exact = solve(drawn, limit_s)
    assert claim.bound_s is not None
    own_ms, bound_ms = round(claim.per_item_s * 1000), round(claim.bound_s * 1000)
    is_true = own_ms >= exact.least_ms and bound_ms <= exact.most_ms
    is_best = own_ms <= exact.most_ms
    seen['mixes'] += 1
    seen['proven'] += claim.is_fastest
    seen['as fast as the best known'] += is_best
    seen['proven by CP-SAT'] += exact.least_ms == exact.most_ms
    seen['wrong'] += not is_true
    verdict = 'true' if is_true else 'WRONG'
    print(
        f'{drawn.name}: {claim}; CP-SAT {exact.least_ms} to {exact.most_ms} ms; '
        f'{took_s:.2f} s; {verdict}',
        flush=True,
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='scripts/mixes', description=__doc__.splitlines()[0])
    parser.add_argument('--mixes', type=int, default=300, help='lines (default 300)')
    parser.add_argument('--seed', type=int, default=1, help='of the first one (default 1)')
    parser.add_argument('--limit', type=float, default=60, help='of CP-SAT for each, in seconds')
    return parser.parse_args()


if __name__ == '__main__':
    sys.exit(main())
