"""The agent that localizes a robot on a map; its thread loads maps and numpy's arrays when it is started."""
