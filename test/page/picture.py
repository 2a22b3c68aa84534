"""Make the picture of the overview that README shows: a line on which a task has failed.

scripts/bootstrap --browser && .venv/jazzy/bin/python test/page/picture.py docs/page.png
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

SIZE = {'width': 1280, 'height': 800}


def main(picture: str) -> None:
    """Make it."""
    root = Path(__file__).parents[2]
    sys.path[:0] = [str(root / 'test'), str(root / 'scripts' / 'environment')]
    from page.browsing import Person, chromium
    from page.stands import stand

    with (
        tempfile.TemporaryDirectory() as folder,
        stand(Path(folder), jobs=3, speed=1.0) as line,
        chromium() as browser,
    ):
        person = Person(browser, f'http://127.0.0.1:{line.port}', viewport=SIZE)
        tab = person.open()
        tab.until(lambda: tab.count('[data-state="Held"]'), 'a cell that is Held')
        tab.until_quiet()
        tab.page.screenshot(path=picture)
        person.leave()


if __name__ == '__main__':
    main(*sys.argv[1:])
