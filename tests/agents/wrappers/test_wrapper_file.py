"""A wrapper's file: errors in one sentence that names it."""

from pathlib import Path

import pytest

from agents.wrappers.wrapped import Wrapped
from agents.wrappers.wrapper_file import WrapperFile
from configs import ConfigError, names

PROGRAM = '[program]\ncommand = ["cat"]\n'
LIBRARY = '[library]\nfile = "m"\n[[functions]]\nname = "f"\n'


@pytest.mark.parametrize("name", names("wrappers"))
def test_each_wrapper_that_comes_with_the_project_can_be_used(name: str) -> None:
    wrapper, path = WrapperFile.load(name)
    Wrapped("it@happy", wrapper, path)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "either a \\[program\\] or a \\[library\\]"),
        (PROGRAM + LIBRARY, "either a \\[program\\] or a \\[library\\]"),
        ("[program]\n", "a command to start, the address of a server, or both"),
        ('[program]\naddress = "nowhere"\n', "HOST:PORT"),
        ('[program]\ncommand = ["cat"]\ncodek = "acts"\n', "did you mean program.codec"),
        ('[program]\ncommand = ["cat"]\ncodec = "xml"\n', "lines, json, acts"),
        (PROGRAM + '[[requests]]\nname = "a"\nsend = "A {b}"\n', "names 'b', which it does not take"),
        (PROGRAM + '[[requests]]\nname = "a"\nsend = "A"\nanswer = "("\n', "no regular expression"),
        (PROGRAM + '[[requests]]\nname = "a"\n', "needs `send`"),
        (PROGRAM + '[[requests]]\nname = "a"\nsend = "A"\n' * 2, "two requests 'a'"),
        (PROGRAM + '[[results]]\nrequest = "b"\nevery_s = 1.0\n', "there is no request 'b'"),
        (PROGRAM + "[[results]]\nevery_s = 1.0\n", "either a line that comes unasked, or a request"),
        (PROGRAM + '[[functions]]\nname = "f"\n', "belong to a \\[library\\]"),
        (LIBRARY.replace('"m"', '"./nothing.so"'), "there is no library .*nothing.so"),
        ('[library]\nfile = "m"\n', "has \\[\\[functions\\]\\]"),
        (LIBRARY + '[[pictures]]\nfunction = "g"\n', "there is no request 'g'"),
        ('[program]\naddress = "a:1"\ncodec = "acts"\n[[requests]]\nname = "colours"\n', "it has blobs, quit"),
        ('[program]\naddress = "a:1"\ncodec = "acts"\nversion = "3"\n', "there are 1.2, 2.0, 1.0"),
    ],
)
def test_an_error_is_told_with_the_file(tmp_path: Path, text: str, why: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=why) as caught:
        Wrapped("it@happy", *WrapperFile.load(str(path)))
    assert str(path) in str(caught.value)
