"""What tests of the command on a bus with keys share."""

import pytest

from acromovi.__main__ import main
from tests.bus.secure_site import Site


class AsOwner:
    """Runs a command of `acromovi` with the key of one of a site's owners."""

    def __init__(self, site: Site, capsys: pytest.CaptureFixture[str]) -> None:
        self._site = site
        self._capsys = capsys

    def __call__(self, owner: str, *arguments: str) -> tuple[int, str, str]:
        """Run it; gives its exit code, what it printed, and what it complained of."""
        code = main([*arguments, "--bus", self._site.profile(owner)])
        return code, *self._capsys.readouterr()


@pytest.fixture
def as_owner(site: Site, capsys: pytest.CaptureFixture[str]) -> AsOwner:
    """For the site that the tests of a file have."""
    return AsOwner(site, capsys)
