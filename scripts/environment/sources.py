"""Which files a package is built from."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable
from pathlib import Path


def find_sources(*paths: Path) -> list[Path]:
    """The given files and all files in the given folders; what tools leave behind is left out."""
    found = [path for path in paths if path.is_file()]
    for root in paths:
        for folder, folders, files in os.walk(root):
            folders[:] = [name for name in folders if not _is_leftover(name)]
            found += [Path(folder, name) for name in files if not name.startswith('.')]
    return sorted(found)


def digest(files: Iterable[Path], root: Path, *salt: str) -> str:
    """A fingerprint of contents, and of names under `root`: the same wherever `root` lies."""
    sha = hashlib.sha256('\0'.join(salt).encode())
    for path in files:
        sha.update(f'\0{path.relative_to(root)}\0'.encode())
        sha.update(path.read_bytes())
    return sha.hexdigest()


def copy_tree(files: Iterable[Path], root: Path, target: Path) -> None:
    """Copy to build from: builds write into their source folder and pick up old leftovers."""
    shutil.rmtree(target, ignore_errors=True)
    for path in files:
        copy = target / path.relative_to(root)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, copy)


def _is_leftover(name: str) -> bool:
    return name in ('__pycache__', 'build') or name.startswith('.') or name.endswith('.egg-info')
