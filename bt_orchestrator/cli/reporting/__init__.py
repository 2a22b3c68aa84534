"""The verb `report`: accounts of shifts, days and jobs."""
