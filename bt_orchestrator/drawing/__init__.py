"""Pictures: a script as a line, how it stands, a run as a Gantt chart."""
