"""What events say: records of jobs and items, times, figures of a run, and exports."""
