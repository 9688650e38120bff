"""The agent that builds a map of the building from the robot's laser or sonar."""
