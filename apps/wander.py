"""Wander: drive straight on, and turn away from near obstacles.

acromovi run APPLICATION robot=happy speed=0.3
acromovi promote APPLICATION
acromovi ask NAME@apps turns
"""

from agents import Team, request

SERVICES = ("wander",)  # for the directory, when it runs as an agent
turns = 0


def main(team: Team, robot: str = "", speed: float = 0.2, near: float = 0.7) -> None:
    """Wander with one robot until stopped; speed in m/s, near: m at which it turns away from an obstacle."""
    global turns
    me = team.robot(robot, having="sonar")  # without a name, any robot that has sonar
    was_near = False
    for _ in team.every(0.1):
        seen = me.sonar.read()
        is_near = seen.nearest < near and abs(seen.bearing) < 1.2  # rad; obstacles behind do not matter
        if is_near:
            me.base.drive(0.0, 0.6)
        else:
            me.base.drive(speed)
        turns += is_near and not was_near
        was_near = is_near


@request("turns")
def how_often() -> int:
    """Return how often the robot has turned away; as an agent, it answers requests with this."""
    return turns
