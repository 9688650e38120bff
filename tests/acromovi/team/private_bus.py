"""A bus of a test's own: a team's robots have names that other tests may use as well."""

import uuid


def private_bus() -> str:
    """A bus of this machine whose programs meet nobody else's."""
    return f"local:test-{uuid.uuid4().hex[:12]}"
