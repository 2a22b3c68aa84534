"""Attack a running line with everything that a peer can do, and say how it bears that.

python -m attack [--only NAME] [--seed N] [--seconds N] [--short] [--json FILE] [--keep FOLDER]
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path

import interrupts
from attack.attacks import ATTACKS
from attack.outcome import HEAD, Outcome
from attack.siege import SILENT_S, Siege
from ros_domain import OwnDomain, discover_fast

SECONDS, SHORT_S = 15.0, 1.0
MOST_MS = 200.0


def main() -> int:
    """Attack; 0 when the line has lost nothing and done nothing twice, and stood still nowhere."""
    args = _arguments()
    interrupts.heed()
    discover_fast()
    names = args.only or [n for n, a in ATTACKS.items() if a.in_short or not args.short]
    seconds = args.seconds or (SHORT_S if args.short else SECONDS)
    most_ms = args.most_ms or (1e3 * SILENT_S if args.short else MOST_MS)
    with OwnDomain(), tempfile.TemporaryDirectory(prefix='attack_') as scratch:
        folder = (args.keep or Path(scratch)).resolve() / 'line'
        folder.mkdir(parents=True)
        siege = Siege(folder, [ATTACKS[n] for n in names], seconds, args.seed, most_ms)
        print(HEAD, flush=True)
        outcome = siege.run(lambda phase: print(phase, flush=True))
    _report(outcome, args.json)
    return 1 if outcome.all_faults else 0


def _report(outcome: Outcome, file: Path | None) -> None:
    print('', *outcome.lines(), sep='\n')
    if file is not None:
        file.write_text(json.dumps(outcome.as_plain(), indent=1) + '\n')


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='scripts/attack',
        description=__doc__.splitlines()[0],
        epilog='attacks:\n' + '\n'.join(_described()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        '--only', action='append', choices=ATTACKS, metavar='NAME', help='may be repeated'
    )
    parser.add_argument('--seed', type=int, default=1, help='of every draw (default 1)')
    parser.add_argument(
        '--seconds', type=float, help=f'of each attack (default {SECONDS:g}; short {SHORT_S:g})'
    )
    parser.add_argument(
        '--most-ms',
        type=float,
        help='how much slower than a plain node a ping may be '
        f'(default {MOST_MS:g}; short {1e3 * SILENT_S:g}: a busy machine is no fault)',
    )
    parser.add_argument('--short', action='store_true', help='the form of the system test')
    parser.add_argument('--json', type=Path, metavar='FILE', help='write all figures there')
    parser.add_argument('--keep', type=Path, metavar='FOLDER', help='keep journals and logs there')
    return parser.parse_args()


def _described() -> list[str]:
    return [
        f'  {name:15}{(attack.__doc__ or "").splitlines()[0]}' for name, attack in ATTACKS.items()
    ]


if __name__ == '__main__':
    sys.exit(main())
