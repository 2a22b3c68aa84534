"""Pictures: a script as a line, the state of that line, a run as a Gantt chart."""
