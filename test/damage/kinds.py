"""How a file is damaged."""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from damage.scene import ENDINGS, NAME, Scene


class Case(NamedTuple):
    """One damage, the same for one number."""

    number: int
    kind: str
    ending: str
    """Of the file."""
    scene: Scene

    @property
    def words(self) -> str:
        """Which one this is."""
        scene = self.scene.folder.parent.name
        return f'case {self.number}: {self.kind} of {NAME}{self.ending} ({scene})'


def flip(drawn: random.Random, file: Path, _: Path) -> None:
    """Change one bit."""
    whole = bytearray(file.read_bytes())
    whole[drawn.randrange(len(whole))] ^= 1 << drawn.randrange(8)
    file.write_bytes(whole)


def zero(drawn: random.Random, file: Path, _: Path) -> None:
    """Lose a block of the disk."""
    whole = bytearray(file.read_bytes())
    length = drawn.choice((512, 4096))
    start = drawn.randrange(-(-len(whole) // length)) * length
    end = min(start + length, len(whole))
    whole[start:end] = bytes(end - start)
    file.write_bytes(whole)


def cut(drawn: random.Random, file: Path, _: Path) -> None:
    """Lose the end of the file."""
    with file.open('r+b') as opened:
        opened.truncate(drawn.randrange(file.stat().st_size))


def swap(drawn: random.Random, file: Path, older: Path) -> None:
    """Lose the file, or put an older one in its place."""
    before = older / file.name
    if before.exists() and drawn.random() < 0.5:
        shutil.copy(before, file)
    else:
        file.unlink()


def alone(drawn: random.Random, file: Path, _: Path) -> None:
    """Keep the journal as a copy of the one file: without its log and its mark, or one of them."""
    journal = file.with_name(NAME)
    others = [journal.with_name(f'{NAME}{ending}') for ending in ENDINGS if ending]
    kept = drawn.choice([None, *others])
    for other in others:
        if other != kept:
            other.unlink(missing_ok=True)


KINDS: Mapping[str, Callable[[random.Random, Path, Path], None]] = {
    'flip': flip,
    'zero': zero,
    'cut': cut,
    'swap': swap,
    'alone': alone,
}


def draw(scenes: list[Scene], number: int) -> Iterator[Case]:
    """Yield so many cases: each kind as often, on each file of each scene in its turn."""
    places = [
        (scene, ending)
        for scene in scenes
        for ending in ENDINGS
        if (scene.folder / f'{NAME}{ending}').exists()
    ]
    for n in range(number):
        kind = list(KINDS)[n % len(KINDS)]
        scene, ending = places[n // len(KINDS) % len(places)]
        yield Case(n, kind, ending, scene)


def damage(case: Case, path: Path, seed: int) -> None:
    """Damage a copy of the files of the case's scene."""
    drawn = random.Random(f'{seed} {case.number}')
    KINDS[case.kind](drawn, path.with_name(path.name + case.ending), case.scene.older)
