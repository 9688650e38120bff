"""The table of pages: their addresses, titles and icons, and the functions that build them.

A page is a module with a function `build(console, visit)`, which is called for each browser that opens it, within the
frame of `shell.py`. What it shows is refreshed by timers of its own (`ui.timer`), which end with the page.
"""

from apps.console import (
    agents_page,
    applications_page,
    faults_page,
    map_page,
    robot_page,
    timeline_page,
    vision_page,
)
from apps.console.page import ConsolePage

PAGES = (
    ConsolePage("/", "Map", "map", map_page.build),
    ConsolePage("/robot", "Robot", "smart_toy", robot_page.build, is_of_robot=True),
    ConsolePage("/vision", "Vision", "photo_camera", vision_page.build, vision_page.is_offered, is_of_robot=True),
    ConsolePage("/agents", "Agents", "hub", agents_page.build),
    ConsolePage("/faults", "Faults", "bolt", faults_page.build, lambda console: console.emulator is not None),
    ConsolePage("/timeline", "Timeline", "history", timeline_page.build),
    ConsolePage(
        "/applications", "Applications", "apps", applications_page.build, lambda console: console.replay is None
    ),
)
"""All pages, in the order of the navigation."""
