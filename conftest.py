"""What all tests share, those of the conformance suite included."""

pytest_plugins = ["tests.schedule", "tests.timeouts"]
