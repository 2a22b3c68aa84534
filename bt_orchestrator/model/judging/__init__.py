"""Judgement of results: the verdict of a task, the serial of its item; lots; used ids."""
