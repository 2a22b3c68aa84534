"""Barriers that axe-core finds in a page (`vendor/README.md`)."""

from __future__ import annotations

from pathlib import Path

from page.browsing import Tab

_AXE = Path(__file__).parent / 'vendor' / 'axe.min.js'

_RUN = """
async () => {
  const { violations } = await axe.run(document, { resultTypes: ['violations'] });
  return violations.flatMap(({ id, help, nodes }) =>
    nodes.map(({ target, failureSummary }) => `${id} (${help}) ${target}: ${failureSummary}`));
}
"""


def barriers(tab: Tab) -> list[str]:
    """Return what stands in somebody's way in what a tab shows now."""
    if not tab.page.evaluate('() => "axe" in window'):
        tab.page.evaluate(_AXE.read_text(encoding='utf-8'))
    violations: list[str] = tab.page.evaluate(_RUN)
    return violations
