"""A pytest plugin: `virtual://` ports, for `pytest -p tests.conformance.plugin pty_tests --port virtual://p2dx`."""

import serial

serial.protocol_handler_packages.append("tests.conformance")
