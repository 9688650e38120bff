"""Indoor navigation by ten components, after the architecture of OROCOS@KTH.

`wiring.toml` says which components there are, in which processes they run, who hears whom, and every number. What flows
is in `data.py`. `components/` are the agents, `algorithms/` what they reckon with: pure functions of readings and time.
"""
