"""Foreign text, such as the words of a controller, for one line of a terminal or a report."""


def one_line(text: str) -> str:
    """Return a text without line ends, and without characters that a terminal obeys."""
    return ''.join(c if c.isprintable() else '\ufffd' for c in ' '.join(text.split()))
