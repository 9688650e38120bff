"""The services of a team: agents that supervise others and serve applications."""
