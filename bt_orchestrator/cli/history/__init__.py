"""The verb `history`: jobs and items of a journal, and Gantt charts of what happened."""
