"""Evaluation of events: records of jobs and items, times, figures of a run, and exports."""
