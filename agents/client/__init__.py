"""The client for sequential scripts: no event loop, no bus, no messages.

    from agents import Team

    with Team() as team:
        for robot in team.robots(having="laser"):
            print(robot.name, robot.laser.nearest())

`Team` (team.py) is the set of robots, `Robot` one of them, `ElementClient` an element; `LoopThread` runs their calls.
"""
