"""The lower layer: an agent for each element of a robot."""
