"""Work orders, the jobs made from them, and the commands to jobs."""
