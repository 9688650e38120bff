"""What all tests share, those of the conformance suite included."""

from tests.timeouts import pytest_timeout_set_timer as pytest_timeout_set_timer
