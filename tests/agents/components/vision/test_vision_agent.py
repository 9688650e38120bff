"""vision@ROBOT: operations on the newest image, on given images, and as streams."""

import asyncio
import base64
import json
from typing import Any

import numpy as np
import pytest

from agents.components.vision.vision_agent import MOST_STREAMS, VisionAgent
from agents.platform import Ending
from bus import JSON
from tests.agents.components.vision.desk import Desk, desk, jpeg
from tests.waiting import waiting
from vision.image import Image, ImageKind

HALVES = np.zeros((120, 160, 3), np.uint8)
HALVES[:, 80:] = 200
EDGES = ["grey", {"operation": "gaussian", "sigma": 2}, "canny"]


def play(story: Any, **properties: Any) -> None:
    async def run() -> None:
        async with desk(VisionAgent("vision@happy", properties)) as at:
            await story(at)

    asyncio.run(run())


def pixels_of(result: dict[str, Any]) -> Image:
    return Image.decode(base64.b64decode(result["data"]))


def test_operations_are_listed_with_types_units_and_ranges() -> None:
    async def story(at: Desk) -> None:
        rows = {row["name"]: row for row in (await at.value("operations"))["operations"]}
        (sigma,) = rows["gaussian"]["parameters"]
        assert sigma == {
            "name": "sigma",
            "type": "number",
            "default": 1.5,
            "low": 0.1,
            "high": 50.0,
            "unit": "px",
        }
        assert {"convolution", "median", "erosion", "otsu", "canny", "sobel", "histogram"} <= rows.keys()

    play(story)


def test_chain_is_applied_to_the_newest_image() -> None:
    async def story(at: Desk) -> None:
        result = (await at.asked_with(HALVES, "apply", chain=EDGES)).value()
        image = pixels_of(result)
        assert {name: result[name] for name in ("format", "kind", "width", "height", "trouble")} == {
            "format": "png",
            "kind": "binary",
            "width": 160,
            "height": 120,
            "trouble": None,
        }
        assert result["stamp"] == pytest.approx(1_700_000_000.0)
        assert result["age"] == pytest.approx(0.25)
        columns = np.flatnonzero(image.pixels.any(axis=0))
        assert 76 <= columns.min() <= columns.max() <= 84

    play(story)


def test_operation_is_applied_with_its_parameters_to_a_given_image_without_a_camera() -> None:
    async def story(at: Desk) -> None:
        grey = np.full((4, 5), 100, np.uint8)
        file = base64.b64encode(Image.of(grey).encode()).decode()
        result = await at.value("apply", chain="threshold", level=99, image=file)
        assert (result["stamp"], result["age"]) == (None, None)
        assert (pixels_of(result).pixels == 255).all()
        assert not at.is_watched
        numbers = await at.value("apply", chain=["grey", {"operation": "histogram", "bins": 2}], image=file)
        assert numbers["numbers"] == {"from": [0, 128], "grey": [20, 0]}

    play(story)


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"chain": "gausian"}, "there is no chain or operation 'gausian' (did you mean gaussian?)"),
        ({"chain": "gaussian", "sigma": 99}, "sigma must be a number from 0.1 to 50 px, not 99"),
        ({"chain": ["otsu", "canny", "histogram", "grey"]}, "step 1: otsu takes a grey or binary image"),
        ({"chain": ["grey"], "sigma": 2}, "the parameters sigma belong into the steps of the chain"),
        ({"chain": 3}, "a chain must be a list of 1 to 32 operations, not int"),
        ({"chain": [{"operation": "convolution", "kernel": [[1, "x"]]}]}, "row 1 of kernel contains 'x'"),
        ({"chain": "grey", "image": "?"}, "the image must be a JPEG or PNG file in base64"),
        ({"chain": "grey", "image": "QUJD"}, "neither a JPEG nor a PNG file"),
        ({"chain": "grey", "image": base64.b64encode(jpeg(HALVES)[:-20]).decode()}, "truncated"),
        ({"chain": "grey", "image": base64.b64encode(jpeg(HALVES)).decode(), "quality": 101}, "quality"),
    ],
)
def test_what_cannot_be_done_is_refused_in_words(given: dict[str, Any], why: str) -> None:
    async def story(at: Desk) -> None:
        outcome = await at.ask("apply", **given)
        assert outcome.ending is Ending.REFUSED
        assert why in outcome.why

    play(story)


HUGE = jpeg(np.zeros((16, 16), np.uint8)).replace(bytes((0, 16, 0, 16)), bytes((0x1B, 0x58, 0x16, 0xB0)), 1)


def test_image_of_forty_megapixels_is_refused_by_its_header() -> None:
    async def story(at: Desk) -> None:
        outcome = await at.ask("apply", chain="blur", image=base64.b64encode(HUGE).decode())
        assert "5808 x 7000 pixels, more than 16 megapixels" in outcome.why

    play(story)


def test_result_that_is_too_large_for_a_message_comes_smaller() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (480, 640, 3), np.uint8)

    async def story(at: Desk) -> None:
        result = (await at.asked_with(jpeg(noise, 60), "apply", chain="blur", quality=0)).value()
        assert (result["format"], result["width"] < 640) == ("jpeg", True)
        assert pixels_of(result).width == result["width"]

    play(story)


def test_named_chain_is_streamed_to_whoever_subscribes_and_only_then() -> None:
    async def story(at: Desk) -> None:
        saved = await at.value("save_chain", name="edges", chain=EDGES)
        assert saved["key"] == "happy/agents/vision/results/edges"
        assert saved["steps"][1] == {"operation": "gaussian", "sigma": 2.0}
        await asyncio.sleep(0.3)
        assert not at.is_watched
        heard = at.hear(saved["key"])
        await at.until(lambda: at.is_watched)
        for _ in range(3):
            at.show(HALVES)
            await at.until(lambda: len(heard) >= at.shown)
        message = heard[-1].decoded()
        assert message.header.stamp.nanosec == 200_000_000
        assert json.loads(heard[-1].attachment) == {"stamp": 1_700_000_000.2, "age": 0.05, "trouble": None}
        assert Image.decode(message.data.tobytes()).kind is ImageKind.GREY

    play(story)


def test_stream_of_a_chain_by_its_content_is_one_for_all_and_ends_without_listeners(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("agents.components.vision.vision_agent.LINGER", 0.2)
    monkeypatch.setattr("agents.components.vision.image_agent.LINGER", 0.2)

    async def story(at: Desk) -> None:
        counts = ["grey", {"operation": "histogram", "bins": 2}]
        stream = await at.value("stream", chain=counts)
        again = await at.value("stream", chain=[{"operation": "grey"}, {"bins": 2, "operation": "histogram"}])
        assert stream == again
        assert stream["type"] == JSON
        heard = at.hear(stream["key"])
        await at.until(lambda: at.is_watched)
        at.show(np.full((4, 5, 3), 90, np.uint8))
        await at.until(lambda: heard)
        result = heard[0].decoded()
        assert result["numbers"]["grey"] == [20, 0]
        assert (result["stamp"], result["age"]) == (1_700_000_000.0, 0.25)
        hearing = []  # all streams, so that none ends
        for number in range(MOST_STREAMS - 1):
            other = await at.value("stream", chain=[{"operation": "gaussian", "sigma": 1 + number}])
            hearing.append(at.bus.subscribe(other["key"], heard.append))
        assert "has 32 streams" in (await at.ask("stream", chain="median")).why
        for each in hearing:
            each.close()
        async with waiting():  # the others end, since nobody listens
            while not (await at.ask("stream", chain="median")).is_done:
                await asyncio.sleep(0.05)

    play(story)


def test_consumers_of_equal_steps_share_the_computation(monkeypatch: pytest.MonkeyPatch) -> None:
    from vision import operations

    computed: list[str] = []
    operation = operations.OPERATIONS["gaussian"]
    run = type(operation).run

    def count(self: Any, image: Any, arguments: Any) -> Any:
        computed.append(self.name)
        return run(self, image, arguments)

    monkeypatch.setattr(type(operation), "run", count)

    async def story(at: Desk) -> None:
        await at.value("save_chain", name="edges", chain=EDGES)
        await at.value("save_chain", name="smooth", chain=EDGES[:2])
        heard = [at.hear(f"happy/agents/vision/results/{name}") for name in ("edges", "edges", "smooth")]
        await at.until(lambda: at.is_watched)
        at.show(HALVES)
        await at.until(lambda: all(heard))
        assert computed == ["grey", "gaussian", "canny"]

    play(story)


def test_slow_operation_skips_images_and_blocks_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    import threading

    from agents.components.vision.chain_tools import ChainTools

    begun, may_end = threading.Semaphore(0), threading.Semaphore(0)
    run = ChainTools.run

    def slow(self: Any, *arguments: Any) -> Any:
        begun.release()
        assert may_end.acquire(timeout=60.0)
        return run(self, *arguments)

    async def story(at: Desk) -> None:
        await at.value("save_chain", name="edges", chain=EDGES)
        heard = at.hear("happy/agents/vision/results/edges")
        await at.until(lambda: at.is_watched)
        monkeypatch.setattr(ChainTools, "run", slow)
        at.show(HALVES)
        await asyncio.to_thread(begun.acquire)
        for _ in range(5):
            at.show(HALVES)
        assert (await at.value("chains"))["chains"]["edges"]["type"].endswith("CompressedImage")
        for _ in range(2):
            may_end.release()
        await at.until(lambda: len(heard) == 2)
        assert heard[1].decoded().header.stamp.nanosec == 500_000_000, "the latest one"

    play(story)


def test_chains_are_removed_and_their_names_are_checked() -> None:
    async def story(at: Desk) -> None:
        await at.value("save_chain", name="edges", chain=EDGES)
        await at.value("save_chain", name="outline", chain="edges")
        assert (await at.value("chains"))["chains"]["outline"]["steps"][0] == {"operation": "grey"}
        assert at.agent.describe()["properties"]["chains"].keys() == {"edges", "outline"}
        assert "did you mean edges?" in (await at.ask("apply", chain="edgs")).why
        assert await at.value("remove_chain", name="edges") == {"chains": ["outline"]}
        assert "saved are: outline" in (await at.ask("remove_chain", name="edges")).why
        for name in ("", "a/b", "*", "gaussian", "x" * 41):
            assert "cannot name a chain" in (await at.ask("save_chain", name=name, chain="grey")).why

    play(story)


def test_chains_move_with_the_agent() -> None:
    async def story(at: Desk) -> None:
        await at.value("save_chain", name="edges", chain=EDGES)
        state = json.loads(json.dumps(at.agent.pack()))
        async with desk(VisionAgent("vision@happy")) as there:
            there.agent.unpack(state)
            heard = there.hear("happy/agents/vision/results/edges")
            await there.until(lambda: there.is_watched)
            there.show(HALVES)
            await there.until(lambda: heard)

    play(story)


def test_without_a_camera_a_request_fails_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(VisionAgent, "first_within", 0.1)

    async def story(at: Desk) -> None:
        outcome = await at.ask("apply", chain="grey")
        assert outcome.ending is Ending.FAILED
        assert outcome.why == "vision@happy has received no image; is the camera of happy there?"

    play(story)


def test_camera_that_is_lost_and_returns_is_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(VisionAgent, "fresh", 0.2)

    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/vision/results")
        await at.until(lambda: at.is_watched)
        at.show(HALVES)
        await at.until(lambda: len(results) == 1)
        await at.until(lambda: len(results) == 2)
        assert "no image has come for 0." in results[1].decoded()["trouble"]
        assert "no image for" in (await at.ask("apply", chain="grey")).why
        at.show(HALVES)
        await at.until(lambda: len(results) == 3)
        assert results[2].decoded()["trouble"] is None
        assert len(at.reports) == 1

    play(story)


@pytest.mark.parametrize(
    ("picture", "why"),
    [
        (np.zeros((120, 160, 3), np.uint8), "the image is black"),
        (jpeg(HALVES)[:-9], "truncated"),
        (jpeg(HALVES)[:-40] + jpeg(HALVES), "torn"),
        (b"no image", "neither a JPEG nor a PNG"),
        (HUGE, "5808 x 7000 pixels, more than 16 megapixels"),
    ],
)
def test_useless_image_is_told_and_the_next_one_is_worked_on(picture: Any, why: str) -> None:
    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/vision/results")
        await at.until(lambda: at.is_watched)
        for each in (picture, HALVES):
            at.show(each)
            await at.until(lambda: len(results) == at.shown)
        assert why in results[0].decoded()["trouble"]
        assert results[1].decoded()["trouble"] is None
        assert [report.what for report in at.reports if why in report.what]

    play(story)


def test_frozen_camera_is_told() -> None:
    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/vision/results")
        await at.until(lambda: at.is_watched)
        for _ in range(11):
            at.show(HALVES)
            await at.until(lambda: len(results) == at.shown)
        assert results[9].decoded()["trouble"] is None
        assert "the camera may be frozen" in results[10].decoded()["trouble"]

    play(story)


def test_equal_images_of_an_emulated_camera_have_no_trouble() -> None:
    async def story(at: Desk) -> None:
        results = at.hear("happy/agents/vision/results")
        await at.until(lambda: at.is_watched)
        for _ in range(12):
            at.show(HALVES)
            await at.until(lambda: len(results) == at.shown)
        assert results[11].decoded()["trouble"] is None

    play(story, emulated=True)


def test_image_that_is_asked_for_many_times_is_not_taken_for_a_frozen_camera() -> None:
    async def story(at: Desk) -> None:
        await at.asked_with(HALVES, "apply", chain="histogram")
        for _ in range(12):
            assert (await at.value("apply", chain="histogram"))["trouble"] is None

    play(story)


def test_stream_whose_chain_does_not_take_the_images_says_why() -> None:
    async def story(at: Desk) -> None:
        stream = await at.value("stream", chain=["otsu", "histogram"])
        heard = at.hear(stream["key"])
        await at.until(lambda: at.is_watched)
        at.show(HALVES)
        await at.until(lambda: heard)
        assert heard[0].decoded()["numbers"] is None
        assert "put the operation grey before it" in heard[0].decoded()["trouble"]

    play(story)


def test_without_the_extra_the_agent_is_not_set_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("configs.extras.find_spec", lambda module: None)

    async def story() -> None:
        agent = VisionAgent("vision@happy")
        made = Desk(agent)
        async with made.container:
            assert not await made.container.start(agent)
        assert "needs the extra vision" in str(made.reports[0].error)

    asyncio.run(story())
