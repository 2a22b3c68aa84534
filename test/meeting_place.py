"""The folder of locks that runs of this machine share, wherever each has its temporary files."""

from __future__ import annotations

from pathlib import Path

LOCKS = Path('/tmp')
