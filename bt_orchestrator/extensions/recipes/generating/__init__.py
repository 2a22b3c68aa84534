"""The verb `generate`: the script of a recipe for a cell."""
