"""Obvious misuse of an exported name raises an error that says what was expected, and not one from somewhere inside."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import agents
import agents.platform as platform
import bus
import cameras
import configs
import gateway
import geometry
import p2os
import p2os_emu

Call = Callable[[], object]

ANYTHING: Any = 3
"""An argument of a type that no function here takes; `Any` hides that from the type checker."""
TEXT: Any = "p3dx"
LIST: Any = [3]

MODEL = configs.load(p2os.RobotModel, "robots", "p3dx")

MISUSES: dict[str, tuple[Call, type[Exception], str]] = {
    "encode_frame without bytes": (lambda: p2os.encode_frame(TEXT), TypeError, "payload must be bytes, not 'p3dx'"),
    "checksum without bytes": (lambda: p2os.checksum(ANYTHING), TypeError, "payload must be bytes, not 3"),
    "decoder without bytes": (lambda: p2os.FrameDecoder().receive(TEXT, 0.0), TypeError, "data must be bytes"),
    "decode_command without bytes": (lambda: p2os.decode_command(TEXT), TypeError, "payload must be bytes"),
    "command that is a list": (lambda: p2os.encode_command(LIST), p2os.EncodeError, "is not a command; give"),
    "empty packet": (lambda: p2os.decode_packet(b"", MODEL), p2os.DecodeError, "the payload is empty"),
    "packet without bytes": (lambda: p2os.decode_packet(TEXT, MODEL), TypeError, "payload must be bytes"),
    "packet with a model's name": (
        lambda: p2os.decode_packet(b"\x32", TEXT),
        TypeError,
        "model must be a RobotModel, not 'p3dx'; give configs.load",
    ),
    "codec with a model's name": (lambda: p2os.SipCodec(TEXT), TypeError, "model must be a RobotModel"),
    "packet that is a number": (
        lambda: p2os.encode_packet(ANYTHING, MODEL),
        TypeError,
        "packet must be one of the packet classes of p2os, not 3",
    ),
    "field that is a text": (
        lambda: p2os.encode_packet(p2os.StandardSip(x=TEXT), MODEL),
        p2os.EncodeError,
        "x p3dx m does not fit its field",
    ),
    "map that is not there": (lambda: geometry.read_map("/nowhere.map"), geometry.MapError, "cannot be read"),
    "settings that are not there": (lambda: configs.read("/no.toml"), configs.ConfigError, "cannot be read"),
    "name that is a number": (
        lambda: configs.find("bus", ANYTHING),
        configs.ConfigError,
        "a name of bus profiles is a text, not 3",
    ),
    "table that is a number": (
        lambda: configs.build(p2os.RobotModel, ANYTHING, "here"),
        configs.ConfigError,
        "here: a table is needed, not 3",
    ),
    "class that is none": (
        lambda: configs.load(ANYTHING, "robots", "p3dx"),
        TypeError,
        "3 is no dataclass and has no from_table",
    ),
    "camera that is a number": (
        lambda: cameras.check_source(ANYTHING),
        cameras.CameraNotUsable,
        "the camera is a text, as http://HOST:PORT/PATH or /dev/video0, not 3",
    ),
    "camera without an address": (
        lambda: cameras.open_source("http://host:port/"),
        cameras.CameraNotUsable,
        "is no address",
    ),
    "picture without bytes": (lambda: cameras.picture_size(TEXT), TypeError, "a picture must be bytes, not str"),
    "bus profile that is a number": (
        lambda: bus.ZenohBus.open(ANYTHING),
        configs.ConfigError,
        "a bus profile is a text, such as 'local', not 3",
    ),
    "key that is a number": (
        lambda: bus.MemoryBus().put(ANYTHING, {}),
        bus.KeyNotValid,
        "3 is not a key; a key is a text, such as happy/odom",
    ),
    "subscriber that is no function": (
        lambda: bus.MemoryBus().subscribe("happy/odom", ANYTHING),
        TypeError,
        "the handler must be a function, not 3",
    ),
    "answer that is no function": (lambda: bus.MemoryBus().serve("a", ANYTHING), TypeError, "must be a function"),
    "conversation that is no function": (
        lambda: bus.MemoryBus().converse("a", ANYTHING),
        TypeError,
        "must be a function",
    ),
    "negative timeout": (lambda: bus.MemoryBus().query("a", timeout=-1.0), ValueError, "a time of 0 s or more, not -1"),
    "timeout that is a text": (lambda: bus.MemoryBus().query("a", timeout=TEXT), ValueError, "not 'p3dx'"),
    "file of settings": (lambda: gateway.load_settings(Path("/no.toml")), configs.ConfigError, "cannot be read"),
    "calibration that is a text": (
        lambda: gateway.Calibration(distance=TEXT),
        ValueError,
        "calibration.distance must be above 0, not p3dx",
    ),
    "time that is a text": (lambda: gateway.Settings(unbound_motion_s=TEXT), ValueError, "must be 0 s or more"),
    "angle that is a text": (lambda: gateway.CameraSettings(TEXT), ValueError, "must be between 0 and pi, not p3dx"),
    "model that is a number": (
        lambda: p2os_emu.start(ANYTHING).__enter__(),
        TypeError,
        r"robot: texts are needed, not \(3,\)",
    ),
    "accessory that is a number": (
        lambda: p2os_emu.start("p3dx", fit=ANYTHING).__enter__(),
        TypeError,
        "fit: texts are needed, not 3",
    ),
    "team on a number": (
        lambda: agents.Team(ANYTHING),
        agents.RobotError,
        "a bus is a profile such as 'local', or an open bus, not 3",
    ),
    "agent with a number as its name": (
        lambda: agents.Agent(ANYTHING),
        platform.NameNotValid,
        "3 names no agent; a name is written like base@happy",
    ),
    "container without a bus": (
        lambda: platform.Container(TEXT),
        TypeError,
        r"a container needs an open bus, such as ZenohBus.open\(\), not 'p3dx'",
    ),
    "decorator without its name": (
        lambda: agents.request(print),  # type: ignore[arg-type]  # this is what is tested
        TypeError,
        r'write it as @request\("name"\)',
    ),
    "topic that is a number": (lambda: agents.on(ANYTHING), TypeError, r'write it as @on\("name"\)'),
    "period of nothing": (lambda: agents.every(0.0), ValueError, r"more than 0 s, not 0.0"),
    "ticker with a text": (lambda: platform.Ticker(TEXT, ANYTHING), ValueError, "more than 0 s, not 'p3dx'"),
    "action that is a number": (
        lambda: platform.OneShot(ANYTHING),
        TypeError,
        "an action is a coroutine function, not 3",
    ),
    "message that is none": (
        lambda: agents.Agent("a@b").send(ANYTHING),
        platform.AclError,
        "only an AclMessage can be sent, not 3",
    ),
    "asker outside a request": (platform.asker, LookupError, "no request is being answered"),
    "agree outside a request": (platform.agree, LookupError, "no request is being answered"),
}


@pytest.mark.parametrize("misuse", MISUSES)
def test_misuse_is_explained(misuse: str) -> None:
    call, kind, message = MISUSES[misuse]
    with pytest.raises(kind, match=message):
        call()


def test_a_team_explains_times_that_are_none() -> None:
    with agents.Team(bus.MemoryBus()) as team:
        with pytest.raises(agents.RobotError, match="within must be a time of 0 s or more, not 'p3dx'"):
            team.robot("happy", within=TEXT)
        with pytest.raises(agents.RobotError, match="within must be a time of 0 s or more, not -1"):
            team.ask("base@happy", "move", within=-1.0)
        with pytest.raises(agents.RobotError, match="sleep takes a time in s, not 'p3dx'"):
            team.sleep(TEXT)


def test_a_fault_that_is_a_number_is_explained(emulated_robot: p2os_emu.RobotForTests) -> None:
    with pytest.raises(TypeError, match="a fault is a text such as 'line-cut@1\\+5', not 3"):
        emulated_robot.fault(ANYTHING)
