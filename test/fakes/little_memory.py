"""Read texts that are made to need a lot, with little memory.

Prints of each whether it was read or refused.
"""

from __future__ import annotations

import resource
from collections.abc import Callable, Mapping
from pathlib import Path

from fakes.files_read import SCRIPTS, refusal
from fakes.profiles import PROFILE

from bt_orchestrator.script.source_text import LARGEST_FILE

SIZE = LARGEST_FILE if PROFILE == 'nightly' else LARGEST_FILE // 10
"""Characters of the texts that are long."""

MEMORY = 256 * 2**20
"""Bytes on top of what the program has before it reads."""


def _laughs(first: str, step: str) -> str:
    steps = (f'a{n}: &a{n} ' + step.replace('*', f'*a{n - 1}') for n in range(1, 40))
    return '\n'.join([f'a0: &a0 {first}', *steps, 'sections: *a39'])


def _filled(line: str) -> str:
    return line * (SIZE // len(line))


BOMBS: Mapping[str, Callable[[], str]] = {
    'laughs in lists': lambda: _laughs('[lol, lol]', '[*, *, *, *, *, *, *, *, *]'),
    'laughs in mappings': lambda: _laughs('{x: lol}', '{x: *, y: *, z: *, components: *}'),
    'laughs in merges': lambda: _laughs('{x: lol}', '{<<: [*, *, *, *], b: *}'),
    'one list a thousand times': lambda: (
        'a: &a [' + 'x, ' * 100_000 + ']\nsections: {' + '1: *a, ' * 1000 + '}'
    ),
    'one mistake a thousand times': lambda: (
        'a: &a ['
        + '{idd: 1}, ' * 10_000
        + ']\nsections: {'
        + ''.join(f'{n}: *a, ' for n in range(9))
        + '}'
    ),
    'a long list': lambda: 'sections:\n' + _filled('- a\n')[:-20],
    'many keys': lambda: ''.join(f'key_{n}: 1\n' for n in range(SIZE // 14)),
    'one key again and again': lambda: _filled('script: a\n'),
    'deep lists': lambda: _filled('['),
    'deep mappings': lambda: _filled('{a: '),
    'deep blocks': lambda: '\n'.join(' ' * n + 'a:' for n in range(2000)),
    'deep dashes': lambda: _filled('- '),
    'many anchors': lambda: ''.join(f'- &a{n} x\n' for n in range(SIZE // 14)),
    'a long key': lambda: 'x' * (SIZE - 10) + ': 1\n',
    'a long number': lambda: 'quantity: ' + '9' * (SIZE - 20),
    'a long quoted text': lambda: 'script: "' + 'x' * (SIZE - 20),
    'many references': lambda: 'script: "' + _filled('${a.b}')[:-40] + '"\n',
    'many documents': lambda: _filled('---\n'),
    'many comments': lambda: _filled('# x\n'),
}


def main() -> None:
    """Read all texts as scripts."""
    refusal(SCRIPTS[0], 'script: x')
    pages = int(Path('/proc/self/statm').read_text(encoding='ascii').split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    for name, make in BOMBS.items():
        outcome = 'read' if refusal(SCRIPTS[0], make()) is None else 'refused'
        print(f'{name}: {outcome}', flush=True)  # noqa: T201 - for the test that started this


if __name__ == '__main__':
    main()
