"""The conformance suite where there is no robot to judge."""

import pytest

import pty_tests.conftest as suite


@pytest.mark.parametrize("port", ["/dev/null", "tcp://nowhere", "/dev/ttyNONE"])
def test_port_that_is_none_is_one_sentence_and_not_one_in_every_test(port: str) -> None:
    with pytest.raises(pytest.UsageError, match=rf"--port {port} cannot be opened: .*; give a device or socket://"):
        suite._check_port("--port", port)
