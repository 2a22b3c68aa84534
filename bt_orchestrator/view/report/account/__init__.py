"""The account of a shift, a day or a job: where the time went, what was made, what failed.

One pass over the events, in memory that does not grow with their number. Times are whole
microseconds and quantities of time exact fractions, so every sum closes. docs/account.md has the
definitions.
"""
