"""Fonts and colours of all pictures; no fact is shown by a colour alone."""

from __future__ import annotations

FONT = 'Helvetica,Arial,sans-serif'
"""The family of all text."""

INK = '#1f2933'
FAINT = '#5f6b7a'
RULE = '#b8c0cc'
PAPER = '#ffffff'
BAR_FILL = '#47525f'
SECTION_FILL = '#f4f6f9'
SLOT_FILL = '#d5dae2'
GROUP_FILL = '#e6ebf2'
FLAG = '#b45309'
BELT = '#8a94a3'
LOOP_LINE = '#4f46e5'
ALARM = '#b00020'
"""Frames of what failed or is held."""
