"""The style of the page of an account, beyond the style of all documents.

Bars have colours by what they count against; what they mean stands beside them in words.
"""

from __future__ import annotations

STYLE = """
.account .tiles { grid-template-columns: 1.5fr repeat(3, 1fr) }
.account .tile span, .account .tile small { display: block; color: var(--quiet); font-size: .87em }
.account .tile b { font-size: 26px }
.account .tile.first b { font-size: 40px; line-height: 1.1 }
.account td { padding-top: 4px; padding-bottom: 4px; overflow-wrap: anywhere }
.account td.number, .account td.time { overflow-wrap: normal }
.account td small { display: block; color: var(--quiet); font-size: .87em }
.account td.number + td:not(.number) { padding-left: 8px }
.account td:last-child, .account th:last-child { padding-right: 0 }
.account .bar { width: 42% }
.account .bar svg { display: block; width: 100%; height: 15px; margin-top: 3px }
.account .is-left td { font-weight: 600; background: var(--panel) }
.account .is-left td:first-child { padding-left: 8px }
.account .is-loss td:first-child { padding-left: 24px }
.account .is-left rect { fill: var(--bar) }
.account .not-busy rect { fill: var(--strong) }
.account .availability rect { fill: var(--bad) }
.account .performance rect { fill: var(--warn) }
.account .quality rect, .account .count rect { fill: var(--note) }
.account .scroll { overflow-x: auto }
.account footer p { margin: 3px 0 }
@media screen and (max-width: 720px) {
  .account .tiles { grid-template-columns: repeat(3, 1fr) }
  .account .tile.first { grid-column: 1 / -1 }
  .account .tile { padding: 8px 10px }
  .account .tile b { font-size: 19px }
  .account .tile.first b { font-size: 34px }
  .account table { font-size: 14px }
  .account .bar { width: 26% }
  .account td, .account th { padding-right: 7px }
  .account .is-loss td:first-child { padding-left: 14px }
}
@media print {
  .account .scroll { overflow: visible }
  .account .whole { break-inside: avoid }
}
"""
