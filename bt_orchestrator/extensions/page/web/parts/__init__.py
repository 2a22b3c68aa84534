"""The view of the page on a cell, as parts: decided here, a browser only draws them.

A part that did not change is equal to the one before, so that it is not sent again.
"""

from bt_orchestrator.extensions.page.web.parts.parts import parts_of

__all__ = ['parts_of']
