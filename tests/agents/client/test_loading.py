"""What a process loads: a program the face, a container none of it."""

import subprocess
import sys

import pytest

import agents

CONTAINERS = "agents.components.robot_agents", "agents.wrappers", "acromovi.container"


def loaded_with(statement: str) -> set[str]:
    """The modules of the face that a process has after this."""
    program = f"import sys; {statement}; print(*(name for name in sys.modules if name.startswith('agents.client')))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_a_robots_container_does_not_carry_the_face() -> None:
    assert not loaded_with(f"import {', '.join(CONTAINERS)}")


def test_a_program_gets_it_with_the_first_name() -> None:
    assert "agents.client.team" in loaded_with("from agents import Team")


def test_editors_see_what_will_be_loaded() -> None:
    assert set(agents.__all__) <= set(dir(agents))


def test_a_name_that_is_not_there_is_told_as_usual() -> None:
    name = "Robots"
    with pytest.raises(AttributeError, match=f"module 'agents' has no attribute '{name}'"):
        getattr(agents, name)
