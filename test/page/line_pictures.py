"""Make the pictures of docs/line.md by following it: the page at the hold, and the shift.

scripts/bootstrap --browser && .venv/jazzy/bin/python test/page/line_pictures.py docs
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

SIZE = {'width': 1280, 'height': 800}


def main(pictures: str) -> None:
    """Make them."""
    root = Path(__file__).parents[2]
    sys.path[:0] = [str(root / 'test'), str(root / 'scripts' / 'environment')]
    from page.browsing import Person, chromium
    from page_reader import PageReader, Typed, typed

    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        reader = PageReader(Path(folder))
        address = ''

        def take(screen: str, name: str) -> None:
            person = Person(browser, address, viewport=SIZE)
            tab = person.open(screen)
            tab.until_quiet()
            tab.page.screenshot(path=Path(pictures, name))
            person.leave()

        try:
            for step in typed(root / 'docs' / 'line.md'):
                reader.follow(step)
                if isinstance(step, Typed) and step.verb == 'page':
                    address = re.findall(r'http://[^/]+', step.shown)[0]
                if isinstance(step, Typed) and step.verb == 'status' and 'hold 1' in step.shown:
                    take('overview', 'line_held.png')
                if step.verb == 'report':
                    take('shift', 'line_shift.png')
            reader.leave()
        finally:
            reader.close()


if __name__ == '__main__':
    main(*sys.argv[1:])
