"""Vision on drawn images with known truth: accuracy of target and time to contact, and the time that each takes.

And how long it takes from an image on the bus to the result of an agent in another process.
"""

import argparse
import base64
import subprocess
import sys
import time
from collections.abc import Callable
from math import cos, degrees, radians, sin
from queue import SimpleQueue

import cv2
import numpy as np

from agents import Team
from benchmarks.figures import Figure, p50_p99, percentile
from benchmarks.vision_drawing import COLOURS, Camera, Flaws, Room, draw, quads, spoilt
from bus import ZenohBus, keys
from bus.messages import CompressedImage, header
from vision.camera_model import PinholeModel
from vision.chain import Chain
from vision.colours import CHANNELS, ColourTable
from vision.contact import ContactEstimator
from vision.image import Image, Pixels
from vision.motion import MotionDetector
from vision.target import TargetFinder, TargetPose, TargetShape

GROUP = "vision"
FIRST_SEED = 120_000  # nothing was tuned on these
POSES, ROOMS = 300, 6
LOOKS = 200  # at one image, for the time that it takes
SPEEDS = (0.3, 0.6)  # m/s
TURN = 0.4  # rad/s at most, to and fro
FRAMES = 45
DT = 1 / 15
COLOUR_MS, CYCLE_MS = 3.0, 15.0
DISTANCE, BEARING, ORIENTATION, CONTACT = 0.03, 0.5, 5.0, 0.15
SMALL = Camera(160, 120)
ROBOT, IMAGES = "bench-eye", 310


def measure(options: argparse.Namespace) -> list[Figure]:
    """Measure all figures."""
    return [*_colours(), *_target(), *_contact(True), *_contact(False), *_others(), *_agents()]


def _times(call: Callable[[], object], count: int = LOOKS) -> list[float]:
    """Milliseconds of processor time of all threads that each call takes."""
    times = []
    for _ in range(count + 10):
        begin = time.process_time()
        call()
        times.append((time.process_time() - begin) * 1e3)
    return times[10:]


def _colours() -> list[Figure]:
    rng = np.random.default_rng(FIRST_SEED)
    image = np.full((240, 320, 3), 90.0)
    regions = []
    for number in range(CHANNELS):
        hsv = np.array([[[number % 16 * 11, 235 if number < 16 else 110, 200]]], np.uint8)
        left, top = number % 8 * 40 + 5, number // 8 * 60 + 5
        image[top : top + 50, left : left + 30] = cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR)[0, 0]
        regions.append((left + 4, top + 4, 22, 42))
    picture, table = spoilt(image, rng, Flaws(noise=4.0)), ColourTable()
    for channel, region in enumerate(regions, 1):
        table.train(channel, picture, region)
    crowded = np.ascontiguousarray(np.tile(picture[:, ::4], (1, 4, 1)))
    alone, many = _times(lambda: table.find(picture)), _times(lambda: table.find(crowded))
    name = "colour tracking, 32 channels, 320x240"
    return [
        Figure(GROUP, f"{name}, one blob each, p50", percentile(alone, 50), COLOUR_MS, "ms", LOOKS),
        Figure(GROUP, f"{name}, four blobs each, p50", percentile(many, 50), COLOUR_MS, "ms", LOOKS),
    ]


def _finder(camera: Camera) -> TargetFinder:
    """Return a finder trained from one image at 1 m."""
    rectangles = quads(1.0, 0.0, 0.0, 0.0)
    image = draw(camera, list(zip(rectangles, COLOURS, strict=True)), np.random.default_rng(FIRST_SEED))
    table = ColourTable()
    for channel, corners in enumerate(rectangles, 1):
        outline = camera.project(corners)
        left, top = (outline.min(axis=0) + 2).astype(int).tolist()
        right, bottom = (outline.max(axis=0) - 2).astype(int).tolist()
        table.train(channel, image, (left, top, right - left, bottom - top))
    return TargetFinder(TargetShape(), table, PinholeModel.from_field_of_view(camera.width, camera.height, camera.view))


def _target() -> list[Figure]:
    figures = []
    for camera in (Camera(), SMALL):
        size = f"{camera.width}x{camera.height}"
        finder, errors, times, wrong = _finder(camera), [], [], 0
        for seed in range(FIRST_SEED, FIRST_SEED + POSES):
            rng = np.random.default_rng(seed)
            distance, to = rng.uniform(0.6, 3.0), radians(rng.uniform(-12, 12))
            heading = to + radians(rng.uniform(-60, 60))
            flaws = Flaws(rng.uniform(1, 5), rng.uniform(0.3, 0.8), rng.uniform(0.5, 1.15), int(rng.integers(75, 95)))
            corners = quads(distance * cos(to), distance * sin(to), 0.0, heading)
            image = draw(camera, list(zip(corners, COLOURS, strict=True)), rng, flaws)
            begin = time.process_time()
            pose = finder.find(image).pose
            times.append((time.process_time() - begin) * 1e3)
            if pose:
                errors.append(_off(pose, distance, to, heading))
                wrong += pose.confidence > 0.5 and (errors[-1][0] > 0.1 or errors[-1][2] > 15.0)
        median = np.median(errors, axis=0).tolist()
        print(f"     {size}: {len(errors)} of {POSES} found, {wrong} wrong with confidence above 0.5")
        figures += [
            Figure(
                GROUP, f"target at 0.6-3 m, +-60 deg, {size}: distance, median", median[0], DISTANCE, "", len(errors)
            ),
            Figure(GROUP, f"target, {size}: bearing, median", median[1], BEARING, "deg", len(errors)),
            Figure(GROUP, f"target, {size}: orientation, median", median[2], ORIENTATION, "deg", len(errors)),
            Figure(GROUP, f"target, {size}: wrong poses with confidence above 0.5", wrong, 0.0, "", POSES),
            Figure(GROUP, f"target, {size}: search and pose, p50", percentile(times, 50), CYCLE_MS, "ms", POSES),
        ]
    return figures


def _off(pose: TargetPose, distance: float, bearing: float, heading: float) -> tuple[float, float, float]:
    return (
        abs(pose.distance / distance - 1),
        degrees(abs(pose.bearing - bearing)),
        degrees(abs(pose.orientation - heading)),
    )


def _contact(is_known: bool) -> list[Figure]:
    """Drive through rooms, straight and turning, and compare every column's time with the true one."""
    model = PinholeModel.from_field_of_view(SMALL.width, SMALL.height, SMALL.view)
    errors: list[float] = []
    times: list[float] = []
    for number in range(ROOMS):
        room, estimator = Room(FIRST_SEED + number), ContactEstimator(model)
        speed, turn = SPEEDS[number % 2], TURN * (number // 2 % 2)
        x, y, heading, turned = 6.0 - speed * 6.5, 0.0, 0.0, 0.0  # 6.5 s before the wall ahead
        for frame in range(FRAMES):
            image = room.image(SMALL, x, y, heading)
            begin = time.process_time()
            result = estimator.update(image, DT, turned if is_known else None)
            times.append((time.process_time() - begin) * 1e3)
            for bearing, found in zip(result.bearings, result.times, strict=True) if result and frame > 5 else ():
                true = room.depth(x, y, heading, bearing) / speed
                if 1.0 <= true <= 8.0:
                    errors.append(abs(min(found, 100.0) - true) / true)
            turned = turn * np.sin(frame / 5) * DT
            x += speed * DT * np.cos(heading + turned / 2)
            y += speed * DT * np.sin(heading + turned / 2)
            heading += turned
    how = "turns by odometry" if is_known else "turns by the flow alone"
    name = f"time to contact, 1-8 s, {how}: error, median"
    return [
        Figure(GROUP, name, float(np.nanmedian(errors)), CONTACT, "", len(errors)),
        Figure(
            GROUP, f"flow and time to contact at 160x120, {how}, p50", percentile(times, 50), CYCLE_MS, "ms", len(times)
        ),
    ]


def _others() -> list[Figure]:
    rng = np.random.default_rng(FIRST_SEED)
    picture: Pixels = draw(Camera(), [], rng)
    image = Image.of(picture)
    chain = Chain.parse(["grey", "gaussian", "canny", {"operation": "dilation", "size": 3}])
    detector, jpeg = MotionDetector(), image.encode(85)
    return [
        *p50_p99(GROUP, "chain of four operations, 320x240", _times(lambda: chain.run(image)), (5.0, 10.0), "ms"),
        *p50_p99(GROUP, "motion, 320x240", _times(lambda: detector.update(picture, DT)), (10.0, 20.0), "ms"),
        *p50_p99(GROUP, "decode a JPEG, 320x240", _times(lambda: Image.decode(jpeg)), (5.0, 10.0), "ms"),
    ]


def _agents() -> list[Figure]:
    """From the put of an image, 320x240, to the result of an agent in another process at a subscriber in this one."""
    rng = np.random.default_rng(FIRST_SEED)
    corners = quads(1.5, 0.0, 0.0, 0.0)
    files = [Image.of(draw(Camera(), list(zip(corners, COLOURS, strict=True)), rng)).encode(85) for _ in range(8)]
    row = {"name": "camera", "streams": [], "commands": [], "field_of_view": Camera().view}
    command = (sys.executable, "-m", "acromovi", "container", "--robot", ROBOT, "--json")
    with ZenohBus.open() as bus, subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as container:
        try:
            bus.serve(keys.DESCRIPTION.key(ROBOT), lambda arguments: {"model": "p3dx-sh", "elements": [row]})
            bus.declare_alive(keys.ELEMENT_ALIVE.key(ROBOT, "camera"))
            with Team() as team:
                team.robot(ROBOT, ("vision", "colours", "flow"), 30.0)
                edges = team.ask(f"vision@{ROBOT}", "save_chain", name="edges", chain=["grey", "gaussian", "canny"])
                table = base64.b64encode(files[0]).decode()
                for channel, outline in enumerate(map(Camera().project, corners), 1):
                    first, last = outline.min(axis=0) + 2, outline.max(axis=0) - 2
                    region = np.concatenate((first, last - first)).astype(int).tolist()
                    team.ask(f"colours@{ROBOT}", "train", channel=channel, region=region, image=table)
            results = {
                "edges by vision": edges["key"],
                "blobs by colours": f"{ROBOT}/agents/colours/results",
                "time to contact by flow": f"{ROBOT}/agents/flow/results",
            }
            return [figure for name, key in results.items() for figure in _delays(bus, name, key, files)]
        finally:
            container.terminate()


def _delays(bus: ZenohBus, name: str, key: str, files: list[bytes]) -> list[Figure]:
    heard: SimpleQueue[float] = SimpleQueue()
    times = []
    with (
        bus.publisher(keys.CAMERA.key(ROBOT), keys.CAMERA.type_name) as camera,
        bus.subscribe(key, lambda sample: heard.put(time.perf_counter()), urgent=True),
    ):
        time.sleep(0.5)  # until the agent before has given up the camera
        while not camera.has_listeners:
            time.sleep(0.01)
        for number in range(IMAGES):
            data = np.frombuffer(files[number % len(files)], np.uint8)
            message = CompressedImage(header=header(time.time_ns(), f"{ROBOT}/camera"), format="jpeg", data=data)
            begin = time.perf_counter()
            camera.put(message)
            times.append((heard.get(timeout=10.0) - begin) * 1e3)
            time.sleep(max(0.0, DT - (time.perf_counter() - begin)))
    what = f"image on the bus to {name} in another process, 320x240"
    return [
        Figure(GROUP, f"{what}, p{percent}", percentile(times[10:], percent), reach, "ms", len(times) - 10)
        for percent, reach in ((50, 20.0), (95, 50.0))
    ]
