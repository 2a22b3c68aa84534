"""The look of the page: light or dark as the reader's computer is, and always light on paper.

Bars have colours by what they count against; what they mean stands beside them in words.
"""

from __future__ import annotations

_LIGHT = """
--paper: #ffffff; --ink: #1c2126; --quiet: #505962; --line: #d3d8de; --band: #f3f4f5;
--left: #47525f; --not-busy: #9aa3ac; --availability: #a8101c; --performance: #b45309;
--quality: #6a3d9a; --count: #1d4f87;"""

_DARK = """
--paper: #1b1e21; --ink: #e6e9ec; --quiet: #aab3bc; --line: #474e55; --band: #25292d;
--left: #a3adb7; --not-busy: #68727c; --availability: #ff8d8d; --performance: #f3a54a;
--quality: #c9a6ef; --count: #8fbdf0;"""

STYLE = f"""
:root {{ {_LIGHT} color-scheme: light dark; }}
@media (prefers-color-scheme: dark) {{ :root {{ {_DARK} }} }}
@media print {{ :root {{ {_LIGHT} color-scheme: light; }} }}
* {{ box-sizing: border-box; }}
body {{ margin: 0 auto; padding: 24px clamp(12px, 4vw, 40px) 40px; max-width: 1080px;
  background: var(--paper); color: var(--ink); line-height: 1.4;
  font: 15px system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }}
header p {{ margin: 2px 0; color: var(--quiet); }}
h1 {{ margin: 0; font-size: 26px; line-height: 1.2; }}
h2 {{ margin: 32px 0 8px; font-size: 17px; break-after: avoid; }}
.tiles {{ display: grid; gap: 1px; margin-top: 20px; background: var(--line);
  border: 1px solid var(--line); grid-template-columns: 1.5fr repeat(3, 1fr); }}
.tile {{ padding: 12px 16px; background: var(--paper); }}
.tile.first {{ background: var(--band); }}
.tile b {{ display: block; font-size: 26px; line-height: 1.25; font-weight: 600; }}
.tile.first b {{ font-size: 40px; line-height: 1.1; }}
.tile span, .tile small {{ display: block; color: var(--quiet); }}
.tile small {{ font-size: 13px; }}
.facts {{ display: flex; flex-wrap: wrap; gap: 4px 32px; margin: 14px 0 0; }}
.facts div {{ display: flex; gap: 8px; }}
.facts dt {{ color: var(--quiet); }}
.facts dd {{ margin: 0; font-weight: 600; }}
table {{ width: 100%; border-collapse: collapse; font-variant-numeric: tabular-nums; }}
th {{ color: var(--quiet); font-weight: 400; font-size: 13px; text-align: left;
  vertical-align: bottom; }}
td, th {{ padding: 4px 12px 4px 0; border-bottom: 1px solid var(--line); }}
td {{ vertical-align: top; overflow-wrap: anywhere; }}
td:last-child, th:last-child {{ padding-right: 0; }}
.n {{ text-align: right; white-space: nowrap; overflow-wrap: normal; }}
.t {{ white-space: nowrap; overflow-wrap: normal; }}
.bar {{ width: 42%; }}
.bar svg {{ display: block; width: 100%; height: 15px; margin-top: 3px; overflow: visible; }}
td small {{ display: block; color: var(--quiet); }}
.left td {{ font-weight: 600; background: var(--band); }}
.left td:first-child, .loss td:first-child {{ padding-left: 8px; }}
.loss td:first-child {{ padding-left: 24px; }}
.left rect {{ fill: var(--left); }}
.not-busy rect {{ fill: var(--not-busy); }}
.availability rect {{ fill: var(--availability); }}
.performance rect {{ fill: var(--performance); }}
.quality rect {{ fill: var(--quality); }}
.count rect {{ fill: var(--count); }}
.scroll {{ overflow-x: auto; }}
footer {{ margin-top: 36px; padding-top: 10px; border-top: 1px solid var(--line);
  color: var(--quiet); font-size: 13px; }}
footer p {{ margin: 3px 0; overflow-wrap: anywhere; }}
@media (max-width: 640px) {{
  body {{ font-size: 14px; }}
  h1 {{ font-size: 22px; }}
  .tiles {{ grid-template-columns: repeat(3, 1fr); }}
  .tile.first {{ grid-column: 1 / -1; }}
  .tile {{ padding: 10px; }}
  .tile b {{ font-size: 20px; }}
  .bar {{ width: 26%; }}
  td, th {{ padding-right: 8px; }}
  .loss td:first-child {{ padding-left: 14px; }}
}}
@page {{ margin: 14mm; }}
@media print {{
  body {{ padding: 0; max-width: none; font-size: 10.5pt; }}
  tr, .tiles, section.whole {{ break-inside: avoid; }}
  rect, .left td, .tile.first {{ print-color-adjust: exact; -webkit-print-color-adjust: exact; }}
  .scroll {{ overflow: visible; }}
}}
"""
