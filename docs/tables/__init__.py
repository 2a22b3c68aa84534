"""Parts of the pages that are made from the code. Each module yields lines of Markdown."""
