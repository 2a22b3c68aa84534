"""What the events of a run or of a journal say: jobs, items, times, figures, exports."""
