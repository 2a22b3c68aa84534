"""Documents: self-contained HTML for screens, light and dark, and for paper."""
