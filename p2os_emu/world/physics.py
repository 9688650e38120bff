"""The physics engine as every world wants it."""

from p2os_emu.world import window
from p2os_emu.world.chassis import GRAVITY
from p2os_emu.world.engine import STEP, PhysicsClient, engine
from p2os_emu.world.errors import WorldError

SOLVER_ITERATIONS = 20
CHAIN_ITERATIONS = 60
"""Where there are chains of joints: with fewer, an arm sags by a degree and the robot under it creeps 5 mm a minute."""


def open_physics(gui: bool) -> PhysicsClient:
    """Begin an empty world.

    Raises:
        WorldError: There is no display for the window, or the engine has no room for one more world.
    """
    client = PhysicsClient(window.connect() if gui else engine.connect(engine.DIRECT))
    if client.number < 0:
        raise WorldError("the physics engine cannot open one more world: close another first (one window at a time)")
    client.setGravity(0.0, 0.0, -GRAVITY)
    client.setPhysicsEngineParameter(
        fixedTimeStep=STEP,
        numSolverIterations=SOLVER_ITERATIONS,
        solverResidualThreshold=0.0,  # never stops early: what is left over would be a creep at rest
        enableConeFriction=0,  # costs a quarter more, to no end: wheels never reach the limit of friction
        deterministicOverlappingPairs=1,
    )
    return client


def solve_chains(client: PhysicsClient) -> None:
    """Work harder from now on: there is a chain of joints."""
    client.setPhysicsEngineParameter(numSolverIterations=CHAIN_ITERATIONS)
