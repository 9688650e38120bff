"""The panel of colour channels: train one by dragging over the image, test, clear, save and load."""

from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments, UploadEventArguments

from apps.remote_vision.program import RemoteVision
from apps.remote_vision.viewing import COLOURS, Viewing
from apps.web.viewer import ImageViewer

_CHANNELS = 32
_LARGEST_FILE = 200_000  # bytes of a file of colours; a message carries 256 KiB


class ColoursPanel:
    """Trains the channels of the robot whose camera a page shows."""

    def __init__(self, program: RemoteVision, viewing: Viewing, image: ImageViewer) -> None:
        """Build the panel.

        Args:
            program: What all pages share.
            viewing: The page.
            image: On which regions are marked.
        """
        self._program = program
        self._viewing = viewing
        self._image = image
        image.on("region", self._train)
        with ui.element("div").classes("rv-panel"):
            ui.label("Colour channels").classes("rv-heading")
            with ui.row().classes("rv-row"):
                self._channel = ui.select(list(range(1, _CHANNELS + 1)), value=1, label="Channel").classes("rv-field")
                self._name = ui.input("Name").props("dense").classes("rv-name")
                ui.switch("Train by dragging over the image", on_change=self._switch)
            with ui.row().classes("rv-row"):
                for words, call in (("Clear channel", self._clear), ("Save channels", self._save)):
                    ui.button(words, on_click=call).props("outline dense no-caps")
                upload = ui.upload(auto_upload=True, max_file_size=_LARGEST_FILE, on_upload=self._load)
                upload.classes("rv-upload").props('aria-hidden="true"')  # the button opens its dialogue of files
                ui.button("Load channels", on_click=lambda: upload.run_method("pickFiles")).props(
                    "outline dense no-caps"
                )
            self._known = ui.label().classes("rv-hint")

    async def refresh(self) -> None:
        """Show which channels are trained."""
        robot = self._viewing.robot
        if not self._program.team.has(robot, COLOURS):
            self._known.text = f"colours@{robot} is not there"
            return
        outcome = await self._program.ask(robot, COLOURS, "channels")
        if outcome.is_done:
            self._show(outcome.result["channels"])

    def _show(self, channels: list[dict[str, Any]]) -> None:
        listed = ", ".join(f"{row['channel']} {row['name']}".strip() for row in channels)
        self._known.text = f"trained: {listed}" if listed else "no channel is trained"

    def _switch(self, event: Any) -> None:
        self._image.mode = "train" if event.value else "steer"

    async def _train(self, event: GenericEventArguments) -> None:
        """Train the chosen channel with a region of the newest image."""
        channel = self._channel.value
        result = await self._ask(
            f"channel {channel} not trained",
            "train",
            channel=channel,
            region=[int(value) for value in event.args["region"]],
            name=self._name.value or "",
        )
        if result is not None:
            self._program.say(self._viewing, f"channel {channel} trained: {result.get('words') or _share(result)}")
            await self.refresh()

    async def _clear(self) -> None:
        result = await self._ask("not cleared", "clear", channel=self._channel.value)
        if result is not None:
            self._program.say(self._viewing, f"channel {self._channel.value} cleared")
            self._show(result["channels"])

    async def _save(self) -> None:
        result = await self._ask("not saved", "save")
        if result is not None:
            ui.download.content(result["colours"].encode(), f"{self._viewing.robot}-colours.txt")
            self._program.say(self._viewing, "channels saved")

    async def _load(self, event: UploadEventArguments) -> None:
        try:
            text = (await event.file.read()).decode()
        except UnicodeDecodeError:
            self._program.say(self._viewing, "not loaded: this is no file of colours")
            return
        result = await self._ask("not loaded", "load", colours=text)
        if result is not None:
            self._program.say(self._viewing, "channels loaded")
            self._show(result["channels"])

    async def _ask(self, failed: str, request: str, **arguments: Any) -> dict[str, Any] | None:
        outcome = await self._program.ask(self._viewing.robot, COLOURS, request, **arguments)
        if outcome.is_done:
            return dict(outcome.result)
        self._program.say(self._viewing, f"{failed}: {outcome.why}")
        return None


def _share(result: dict[str, Any]) -> str:
    return f"{result.get('hits', 0.0):.0%} of the region"
