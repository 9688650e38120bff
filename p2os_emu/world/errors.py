"""Errors of worlds."""


class WorldError(ValueError):
    """A world cannot be built, or a robot cannot stand there; one sentence that says what to do."""
