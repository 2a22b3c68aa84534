"""Work orders on the command line: their files, the terms of queued jobs, and the answers."""
