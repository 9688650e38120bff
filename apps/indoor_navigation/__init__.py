"""Indoor navigation by ten components, in the architecture of OROCOS@KTH.

`wiring.toml` gives the components, their processes, connections and parameters. The data that they exchange are in
`data.py`. `components/` are the agents; `algorithms/` are pure functions of readings and time.
"""
