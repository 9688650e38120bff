"""Navigation missions in lockstep: run, judged by the true state, and reported in a table with pictures."""
