"""The documentation site has every page, in the list of its kind (docs/conf.py)."""

from __future__ import annotations

import conf
from fakes.shipped import ROOT


def test_the_site_lists_every_page_once() -> None:
    listed = [name for pages in conf.pages_by_kind().values() for name in pages]
    pages = {path.stem for path in (ROOT / 'docs').glob('*.md')} - {'README'}
    assert sorted(listed) == sorted({*pages, 'decisions/README'})
