"""Making scripts: from a recipe and a cell to the lists of the sections (docs/recipes.md)."""
