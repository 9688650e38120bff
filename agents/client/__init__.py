"""The client for scripts that do one thing after the other: no event loop, no bus, no messages.

    from agents import Team

    with Team() as team:
        for robot in team.robots(having="laser"):
            print(robot.name, robot.laser.nearest())

`Team` (team.py) is all robots, `Robot` one of them, `ElementClient` a part of it; `LoopThread` makes their calls.
"""
