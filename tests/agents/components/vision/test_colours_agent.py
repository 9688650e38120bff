"""colours@ROBOT: channels that are trained, tested, saved and loaded, and clients of ACTS."""

import asyncio
import base64
import json
import socket
from collections.abc import Mapping
from math import atan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.components.vision.colours_agent import ColoursAgent
from agents.platform import AgentName, Ending
from agents.wrappers.acts import packet
from agents.wrappers.wrapped import Wrapped
from agents.wrappers.wrapper_file import WrapperFile
from tests.agents.components.vision.desk import Desk, desk
from tests.agents.wrappers import acts_server
from tests.waiting import waiting
from vision.image import Image

RED, BLUE = (30, 30, 200), (200, 60, 30)
VIEW = 1.0  # rad


def scene(red_left: int = 20) -> np.ndarray:
    """A red rectangle of 40 x 50 px and a blue one of 20 x 20 px on grey."""
    image = np.full((120, 160, 3), 110, np.uint8)
    image[30:80, red_left : red_left + 40] = RED
    image[90:110, 120:140] = BLUE
    return image


def png(pixels: np.ndarray) -> bytes:
    return Image.of(pixels).encode()


def text(pixels: np.ndarray) -> str:
    return base64.b64encode(png(pixels)).decode()


def play(story: Any, **properties: Any) -> None:
    async def run() -> None:
        async with desk(ColoursAgent("colours@happy", properties)) as at:
            await story(at)

    asyncio.run(run())


async def train(at: Desk) -> None:
    await at.value("train", channel=1, region=[25, 35, 30, 40], name="red", image=text(scene()))
    await at.value("train", channel=7, region=[122, 92, 16, 16], image=text(scene()))


def test_channel_is_trained_from_a_region_of_the_newest_image_and_finds_it() -> None:
    async def story(at: Desk) -> None:
        told = (await at.asked_with(png(scene()), "train", channel=1, region=[25, 35, 30, 40], name="red")).value()
        assert told["hits"] == 1.0
        assert told["words"].startswith("channel 1 has 100% of the region")
        result = (await at.asked_with(png(scene(70)), "blobs")).value()
        assert result["channels"] == {
            "1": [
                {
                    "area": 2000,
                    "x": 89.5,
                    "y": 54.5,
                    "left": 70,
                    "right": 109,
                    "top": 30,
                    "bottom": 79,
                    "bearing": None,
                    "elevation": None,
                }
            ]
        }
        assert (await at.value("channels"))["channels"] == [{"channel": 1, "name": "red", "colours": 1}]
        assert (await at.value("test", channel=1, region=[30, 40, 5, 5], image=text(scene())))["hits"] == 1.0

    play(story)


def test_blobs_have_bearings_where_the_field_of_view_is_known() -> None:
    async def story(at: Desk) -> None:
        await train(at)
        (blob,) = (await at.value("blobs", image=text(scene())))["channels"]["1"]
        focal = 80.0 / np.tan(VIEW / 2)
        assert blob["bearing"] == pytest.approx(atan((79.5 - 39.5) / focal), abs=1e-3)
        assert blob["elevation"] == pytest.approx(atan((59.5 - 54.5) / np.hypot(focal, 40.0)), abs=1e-3)

    play(story, field_of_view=VIEW)


def test_results_are_published_for_each_image_while_somebody_listens() -> None:
    async def story(at: Desk) -> None:
        await train(at)
        heard = at.hear("happy/agents/colours/results")
        await at.until(lambda: at.is_watched)
        for left in (20, 40):
            at.show(png(scene(left)))
            await at.until(lambda: len(heard) == at.shown)
        results = [sample.decoded() for sample in heard]
        assert [result["channels"]["1"][0]["left"] for result in results] == [20, 40]
        assert (results[1]["stamp"], results[1]["age"]) == (1_700_000_000.1, pytest.approx(0.15))

    play(story)


def test_channels_are_saved_loaded_and_move_with_the_agent() -> None:
    async def story(at: Desk) -> None:
        await train(at)
        saved = (await at.value("save"))["colours"]
        assert saved.splitlines()[2] == "channel 1 red"
        assert (await at.value("clear", channel=1))["channels"] == [{"channel": 7, "name": "", "colours": 1}]
        loaded = await at.value("load", colours=saved)
        assert [row["channel"] for row in loaded["channels"]] == [1, 7]
        state = json.loads(json.dumps(at.agent.pack()))
        async with desk(ColoursAgent("colours@happy")) as there:
            there.agent.unpack(state)
            assert (await there.value("save"))["colours"] == saved

    play(story)


@pytest.mark.parametrize(
    ("name", "given", "why"),
    [
        ("train", {"channel": 33, "region": [0, 0, 9, 9]}, "a channel is a number from 1 to 32, not 33"),
        ("train", {"channel": 1, "region": [0, 0, 9]}, "a region is [left, top, width, height]"),
        ("train", {"channel": 1, "region": 5}, "a region is [left, top, width, height]"),
        ("train", {"channel": 1, "region": [0, 0, 900, 9]}, "is not inside the image of 160 x 120 px"),
        ("train", {"channel": 1, "region": [10, 30, 60, 40]}, "the region has several colours"),
        ("blobs", {"smallest": 0}, "smallest is an area of at least 1 px, not 0"),
        ("test", {"channel": 0, "region": [0, 0, 9, 9]}, "from 1 to 32"),
    ],
)
def test_wrong_training_is_refused_in_words(name: str, given: dict[str, Any], why: str) -> None:
    colourful = scene()
    colourful[30:80, 40:60] = BLUE

    async def story(at: Desk) -> None:
        outcome = await at.ask(name, image=text(colourful), **given)
        assert outcome.ending is Ending.REFUSED
        assert why in outcome.why

    play(story)


def test_wrong_file_port_and_version_are_refused_in_words(free_port: int) -> None:
    async def story(at: Desk) -> None:
        assert "line 1 of the file of colours must be" in (await at.ask("load", colours="red = 1")).why
        assert "a TCP port is a number from 1 to 65535" in (await at.ask("serve_acts", port=70000)).why
        assert "there are 1.0, 1.2 and 2.0" in (await at.ask("serve_acts", port=free_port, version="3")).why
        with socket.create_server(("127.0.0.1", free_port)):
            assert "give another port" in (await at.ask("serve_acts", port=free_port)).why
        assert (await at.value("channels"))["acts_port"] is None
        assert (await at.value("serve_acts", port=free_port, version=1.2))["acts_port"] == free_port

    play(story)


def blob_of(area: int, x: int, y: int, left: int, right: int, top: int, bottom: int) -> Mapping[str, float]:
    return {"area": area, "x": x, "y": y, "left": left, "right": right, "top": top, "bottom": bottom}


def test_packet_is_byte_for_byte_that_of_acts() -> None:
    rows = {1: [(5000, 80, 60, 40, 120, 30, 90), (12, 5, 6, 4, 6, 5, 7)], 7: [(70, 20, 10, 15, 25, 5, 15)]}
    expected = acts_server.packet({number: [acts_server.blob(*row) for row in blobs] for number, blobs in rows.items()})
    assert packet({number: [blob_of(*row) for row in blobs] for number, blobs in rows.items()}, "2.0") == expected
    assert packet({}, "1.2") == b"\x01\x01\x01\x01" * 32


def test_packet_of_the_oldest_version_is_byte_for_byte_as_the_sheet_says() -> None:
    sent = packet({1: [blob_of(66, 159, 119, 1, 159, 0, 119)]}, "1.0")
    assert sent == b"\x01\x02" + b"\x02\x01" * 31 + b"\x01\x01\x02\x03" + bytes([160, 120, 2, 160, 1, 120])
    crowded = {channel: [blob_of(9, 300, 1, 1, 1, 1, 1)] * 12 for channel in range(1, 33)}
    sent = packet(crowded, "1.0")
    assert len(sent) == 64 + 254 * 10, "an index has one byte"
    assert sent[64 + 4] == 255, "the largest number of a byte"


@pytest.fixture
def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
    return port


async def film(at: Desk) -> None:
    """Show an image whenever the agent wants some."""
    while True:
        if at.is_watched:
            at.show(png(scene()))
        await asyncio.sleep(0.02)


@pytest.mark.parametrize("version", ["1.0", "1.2", "2.0"])
def test_wrapper_of_acts_works_with_it_as_with_the_original(version: str, free_port: int, tmp_path: Path) -> None:
    wrapper = tmp_path / "acts.toml"
    wrapper.write_text(
        f'[program]\naddress = "127.0.0.1:{free_port}"\ncodec = "acts"\nversion = "{version}"\n'
        '[[requests]]\nname = "blobs"\n[[requests]]\nname = "quit"\n'
        '[[results]]\nrequest = "blobs"\nevery_s = 0.02\n'
    )
    client = AgentName("acts", "lab")

    async def story(at: Desk) -> None:
        await train(at)
        assert not at.is_watched
        filming = asyncio.ensure_future(film(at))
        heard = at.hear(client.results_key)
        assert await at.container.start(Wrapped(client, *WrapperFile.load(str(wrapper))))
        blobs = (await at.app.request(client, "blobs")).value()["blobs"]
        red = {"area": 2000, "x": 40, "y": 54, "left": 20, "right": 59, "top": 30, "bottom": 79}
        blue = {"area": 400, "x": 130, "y": 100, "left": 120, "right": 139, "top": 90, "bottom": 109}
        assert blobs == [{"channel": 1} | red, {"channel": 7} | blue]
        await at.until(lambda: len(heard) >= 3)
        assert heard[-1].decoded()["blobs"] == blobs
        assert (await at.app.request(client, "quit")).is_done
        async with waiting():  # it serves others as well, so it goes on
            while not (await at.app.request(client, "blobs")).is_done:
                await asyncio.sleep(0.02)
        await at.container.stop(client)
        await at.until(lambda: not at.is_watched)
        filming.cancel()

    play(story, acts_port=free_port, acts_version=version)


def test_client_of_acts_without_a_camera_gets_no_blobs(free_port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.components.vision.colours_agent.FIRST_TIME", 0.1)

    async def story(at: Desk) -> None:
        await train(at)
        await at.value("serve_acts", port=free_port)
        reader, writer = await asyncio.open_connection("127.0.0.1", free_port)
        writer.write(b"0")
        assert await reader.readexactly(128) == packet({})
        await at.value("serve_acts", port=0)
        assert await reader.read() == b"", "the connection ends with the server"
        writer.close()

    play(story)


def test_client_of_acts_that_reads_nothing_delays_nobody(free_port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.components.vision.colours_agent.FIRST_TIME", 0.01)
    monkeypatch.setattr("agents.components.vision.acts_server.READING_TIME", 0.2)

    async def story(at: Desk) -> None:
        await at.value("serve_acts", port=free_port)
        _, lazy = await asyncio.open_connection("127.0.0.1", free_port)
        lazy.transport.pause_reading()  # type: ignore[attr-defined]  # a transport of a socket has it
        lazy.write(b"0" * 200_000)
        reader, writer = await asyncio.open_connection("127.0.0.1", free_port)
        for _ in range(20):
            writer.write(b"0")
            assert await reader.readexactly(128) == packet({})
        writer.write(b"x1")  # something else is left out
        assert await reader.read() == b""
        writer.close()
        lazy.transport.abort()

    play(story)
