"""The engine: commands in, behaviour tree ticked, events out, goals sent. One thread."""
