"""C libraries as agents: values, bytes and pictures through functions, and one that crashes."""

import asyncio
import base64
from pathlib import Path

import cv2
import numpy
import pytest

from agents.platform import Ending
from agents.wrappers.frames import FramesCodec, FrameSplitter
from bus import keys
from bus.messages import CompressedImage, header
from tests.agents.wrappers.conftest import bench
from tests.waiting import waiting

FILE = """
services = ["filters"]
[library]
file = {library!r}

[[functions]]
name = "threshold"
arguments = [
  {{name = "image", kind = "bytes"}}, {{name = "width", kind = "int32"}}, {{name = "height", kind = "int32"}},
  {{name = "level", kind = "uint8"}}, {{name = "out", kind = "out", size = "width*height"}},
]
defaults = {{level = 128}}
fails_below = 0
why = "a picture needs pixels"

[[functions]]
name = "mean"
arguments = [
  {{name = "image", kind = "bytes"}}, {{name = "width", kind = "int32"}}, {{name = "height", kind = "int32"}},
]
returns = "double"

[[functions]]
name = "length"
symbol = "length_of"
arguments = [{{name = "text", kind = "text"}}]

[[functions]]
name = "crash"
returns = "void"

[[pictures]]
function = "threshold"
out = "out"
"""


@pytest.fixture
def file(filters: Path, tmp_path: Path) -> Path:
    path = tmp_path / "filters.toml"
    path.write_text(FILE.format(library=str(filters)))
    return path


def as_text(image: bytes) -> str:
    return base64.b64encode(image).decode()


def test_functions_take_and_give_values_text_and_bytes(file: Path) -> None:
    async def scenario() -> None:
        async with bench(file) as at:
            image = bytes([0, 100, 127, 128, 200, 255])
            done = (await at.ask("threshold", image=as_text(image), width=3, height=2, level=128)).value()
            assert done["value"] == 3
            assert base64.b64decode(done["out"]) == bytes([0, 0, 0, 255, 255, 255])
            assert (await at.ask("mean", image=as_text(b"\x01\x03"), width=2, height=1)).value() == {"value": 2.0}
            assert (await at.ask("mean", image="", width=0, height=0)).value() == {"value": None}
            assert (await at.ask("length", text="grüß dich")).value() == {"value": 11}

    asyncio.run(scenario())


def test_what_does_not_fit_is_refused_and_harms_nothing(file: Path) -> None:
    async def scenario() -> None:
        async with bench(file) as at:
            failed = await at.ask("threshold", image="", width=0, height=0)
            assert (failed.ending, failed.why) == (Ending.FAILED, "a picture needs pixels (-1)")
            for wrong, why in (
                ({"image": "no base64!", "width": 1, "height": 1}, "must be base64"),
                ({"image": "AA==", "width": 1, "height": 1, "level": 256}, "level of 256 does not fit uint8"),
                ({"image": "AA==", "width": 1 << 20, "height": 1 << 20}, "too large"),
                ({"image": "AA==", "width": -1, "height": 1}, "cannot be told"),
            ):
                outcome = await at.ask("threshold", **wrong)
                assert why in outcome.why
            assert (await at.ask("length", text="still here")).is_done

    asyncio.run(scenario())


def test_a_function_that_crashes_harms_neither_agent_nor_container(file: Path) -> None:
    async def scenario() -> None:
        async with bench(file) as at:
            crashed = await at.ask("crash")
            assert crashed.ending is Ending.FAILED
            assert "SIGABRT" in crashed.why
            async with waiting():
                while not (await at.ask("length", text="four")).is_done:
                    await asyncio.sleep(0.02)

    asyncio.run(scenario())


def test_pictures_of_the_camera_go_through_a_function(file: Path) -> None:
    grey = numpy.zeros((24, 32), numpy.uint8)
    grey[:, 16:] = 255
    coded = numpy.frombuffer(cv2.imencode(".png", grey)[1].tobytes(), numpy.uint8)

    async def scenario() -> None:
        async with bench(file) as at:
            seen: list[CompressedImage] = []

            async def look(message: CompressedImage) -> None:
                seen.append(message)

            at.console.listen("happy/agents/it/image/compressed", look)
            picture = CompressedImage(header(1_500_000_000, "happy/camera"), format="png", data=coded)
            at.console.bus.put(keys.CAMERA.key("happy"), picture)
            await at.until(lambda: seen and at.results)
            assert at.results == [{"value": 24 * 16, "stamp": 1.5, "width": 32, "height": 24}]
            back = cv2.imdecode(numpy.frombuffer(bytes(seen[0].data), numpy.uint8), cv2.IMREAD_GRAYSCALE)
            assert back is not None
            assert back.shape == (24, 32)
            assert back[:, :14].max() < 60 < 200 < back[:, 18:].min()

    asyncio.run(scenario())


def test_a_library_that_cannot_be_loaded_is_told(tmp_path: Path) -> None:
    (tmp_path / "nothing.so").write_text("no library")
    path = tmp_path / "nothing.toml"
    path.write_text('[library]\nfile = "./nothing.so"\n[[functions]]\nname = "f"\n')

    async def scenario() -> None:
        async with bench(path) as at:
            await at.until(lambda: at.reports)
            assert "nothing.so" in str(at.reports[0].error)

    asyncio.run(scenario())


def test_frames_come_whole_out_of_any_portions() -> None:
    said = FramesCodec().ask("f", {"image": b"\n{}\n", "level": 3}) * 2
    splitter = FrameSplitter()
    frames = [frame for i in range(len(said)) for frame in splitter.receive(said[i : i + 1])]
    assert [(head["function"], head["arguments"], blobs) for head, blobs in frames] == [
        ("f", {"level": 3}, {"image": b"\n{}\n"})
    ] * 2
