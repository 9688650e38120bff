"""A robot with its agents under one virtual clock, as the tests of the components have it."""

from tests.agents.components.conftest import loop as loop
from tests.agents.components.conftest import make_lab as make_lab
