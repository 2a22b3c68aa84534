"""Sphinx: the pages of docs/, README and CONTRIBUTING as one site, made by scripts/docs.

The source folder is the repository, so a link or picture is the same here and on a page of files.
The list of pages is the table of docs/README.md, which says the kind of each.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[1]
KINDS = {
    'tutorial': 'Tutorials: learn in order',
    'how-to': 'How-to: solve one problem',
    'reference': 'Reference: look up',
    'explanation': 'Explanation: why',
}
DEVELOPING = ('CONTRIBUTING', 'docs/examples/extension/README', 'SECURITY', 'CHANGELOG')

project = 'bt_orchestrator'
release = re.findall('<version>(.+)</version>', (ROOT / 'package.xml').read_text())[0]
copyright = 'the maintainers of bt_orchestrator, Apache-2.0'  # noqa: A001
root_doc = 'README'
include_patterns = ['README.md', 'CONTRIBUTING.md', 'SECURITY.md', 'CHANGELOG.rst', 'docs/**.md']
exclude_patterns = ['.*', 'bench', 'bt_orchestrator', 'build', 'install', 'log', 'test']

extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx_copybutton']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
myst_heading_anchors = 6
# What is typed, without what is shown.
copybutton_prompt_text = '$ '
copybutton_only_copy_prompt_lines = True
# Docstrings say `name` for code, as the pages do.
default_role = 'code'
autodoc_member_order = 'bysource'
autodoc_default_options = {'members': True, 'show-inheritance': True}
autodoc_typehints_format = 'short'
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False
toc_object_entries_show_parents = 'hide'

html_theme = 'furo'
html_title = f'{project} {release}'
html_static_path = ['site']
html_css_files = ['site.css']
html_copy_source = False
html_show_sphinx = False


def pages_by_kind() -> dict[str, list[str]]:
    """Return the pages of the table "By question" in their order, by kind."""
    table = (ROOT / 'docs' / 'README.md').read_text(encoding='utf-8')
    table = table.partition('## By question\n')[2].partition('\n## ')[0]
    pages: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for links, kind in re.findall(r'^\|[^|]+\|([^|]+)\| ([\w-]+) \|$', table, re.MULTILINE):
        if kind in pages:
            pages[kind] += re.findall(r'\]\(([\w/]+)\.md\)', links)
    return pages


def toctree(caption: str, pages: list[str] | tuple[str, ...]) -> str:
    """Return a list of pages that is shown at the side only."""
    lines = ('```{toctree}', ':hidden:', f':caption: {caption}', '', *pages, '```')
    return '\n'.join(lines) + '\n\n'


def add_lists(_app: Sphinx, page: str, text: list[str]) -> None:
    """Give the first page the lists of the others, and its place to each decision."""
    if page == root_doc:
        parts = [toctree('All pages', ('docs/README',))]
        for kind, pages in pages_by_kind().items():
            parts.append(toctree(KINDS[kind], [f'docs/{name}' for name in pages]))
        parts.append(toctree('Changing the program', DEVELOPING))
        text[0] += '\n\n' + ''.join(parts)
    if page.startswith('docs/decisions/0'):
        # Listed on a page of their own: at the side of every page they would be most of the build.
        text[0] = f'---\norphan: true\n---\n\n{text[0]}'


def begin_at_the_first_page(app: Sphinx, error: Exception | None) -> None:
    """A server shows index.html to whoever asks for the folder."""
    first = Path(app.outdir, f'{root_doc}.html')
    if error is None and first.exists():
        shutil.copyfile(first, first.with_name('index.html'))


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect('source-read', add_lists)
    app.connect('build-finished', begin_at_the_first_page)
