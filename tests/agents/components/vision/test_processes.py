"""The agents in a container of their own process, and a program that knows only Zenoh."""

import asyncio
import json
import subprocess
import sys
import uuid
from collections.abc import Iterator

import numpy as np
import pytest
import zenoh

from agents.components.all_components import DERIVED
from bus import ZenohBus, keys, messages
from bus.messages import CompressedImage, decode
from tests.agents.components.application import application, container
from tests.agents.components.vision.desk import jpeg
from tests.plain_zenoh import plain_session
from tests.waiting import end_of, wait_until
from vision.image import Image

HALVES = np.zeros((120, 160, 3), np.uint8)
HALVES[:, 80:] = 200


@pytest.fixture
def robot() -> str:
    return f"eye{uuid.uuid4().hex[:6]}"


@pytest.fixture
def gateway(robot: str) -> Iterator[ZenohBus]:
    """A bus on which this robot has a camera and nothing else."""
    row = {"name": "camera", "streams": [keys.CAMERA.key(robot)], "commands": [], "field_of_view": 1.0}
    with ZenohBus.open() as bus:
        bus.serve(keys.DESCRIPTION.key(robot), lambda arguments: {"model": "p3dx-sh", "elements": [row]})
        bus.declare_alive(keys.ELEMENT_ALIVE.key(robot, "camera"))
        yield bus


def test_plain_program_gets_the_result_of_a_chain_from_another_process(robot: str, gateway: ZenohBus) -> None:
    async def save() -> str:
        async with application(robot) as app:
            await app.find({"camera", *DERIVED["camera"]})
            saved = await app.ask("vision", "save_chain", name="light", chain=["grey", "otsu"])
            return str(saved["key"])

    results: list[zenoh.Sample] = []
    with container(robot), gateway.publisher(keys.CAMERA.key(robot), keys.CAMERA.type_name) as camera:
        key = asyncio.run(save())
        assert not camera.has_listeners
        with plain_session() as session:
            session.declare_subscriber(key, results.append)
            wait_until(lambda: camera.has_listeners, "the agent subscribes to the camera")
            head = messages.header(1_700_000_000_000_000_000, f"{robot}/camera")
            camera.put(CompressedImage(header=head, format="jpeg", data=np.frombuffer(jpeg(HALVES), np.uint8)))
            wait_until(lambda: results, "the result comes")
        wait_until(lambda: not camera.has_listeners, "the agent gives up the camera")
    assert str(results[0].encoding) == "application/cdr;sensor_msgs/msg/CompressedImage"
    image: CompressedImage = decode(keys.CAMERA.type_name, results[0].payload.to_bytes())
    assert image.header.stamp.sec == 1_700_000_000
    pixels = Image.decode(image.data.tobytes()).pixels
    assert (pixels[:, 90:] == 255).all()
    assert (pixels[:, :70] == 0).all()
    attachment = results[0].attachment
    assert attachment is not None
    assert json.loads(attachment.to_bytes())["trouble"] is None


def test_command_line_asks_for_an_operation_with_its_parameters(robot: str, gateway: ZenohBus) -> None:
    async def find() -> None:
        async with application(robot) as app:
            await app.find({"vision"})

    with container(robot), gateway.publisher(keys.CAMERA.key(robot), keys.CAMERA.type_name) as camera:
        asyncio.run(find())
        command = (sys.executable, "-m", "acromovi", "ask", f"vision@{robot}", "apply", "chain=histogram", "bins=2")
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as asking:
            wait_until(lambda: camera.has_listeners, "the agent subscribes to the camera")
            head = messages.header(1_700_000_000_000_000_000, f"{robot}/camera")
            camera.put(CompressedImage(header=head, format="jpeg", data=np.frombuffer(jpeg(HALVES), np.uint8)))
            printed, _ = end_of(asking)
    assert json.loads(printed)["numbers"]["red"] == [9600, 9600]
