"""`acromovi remote-vision`: what it says when the page cannot be served."""

import socket

import pytest

from acromovi.__main__ import main
from tests.acromovi.team.private_bus import private_bus


def test_a_robot_that_is_not_there_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["remote-vision", "nobody", "--port", "0", "--bus", private_bus()]) == 1
    assert "acromovi remote-vision: there is no robot 'nobody'" in capsys.readouterr().err


def test_a_port_in_use_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        assert main(["remote-vision", "happy", "--port", port, "--bus", private_bus()]) == 1
    error = capsys.readouterr().err
    assert f"the page cannot be served on 127.0.0.1:{port}" in error
    assert "choose another port or host" in error


@pytest.mark.parametrize(("port", "why"), [("web", "web is not a TCP port"), ("70000", "70000 is not a TCP port")])
def test_what_is_no_port_is_wrong_usage(port: str, why: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["remote-vision", "happy", "--port", port])
    assert ended.value.code == 2
    assert why in capsys.readouterr().err


def test_the_help_has_an_example_and_the_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["remote-vision", "--help"])
    shown = capsys.readouterr().out
    assert "acromovi remote-vision happy" in shown
    assert "Exit codes" in shown
