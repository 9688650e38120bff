"""Missions of the navigation in lockstep: played, judged by the truth, and laid out in a table with pictures."""
