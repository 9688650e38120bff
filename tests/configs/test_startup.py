import gc

import pytest

from configs.startup import uncollected


@pytest.mark.parametrize("is_enabled", [True, False])
def test_nothing_is_collected_in_the_block_and_the_collector_is_as_before_afterwards(is_enabled: bool) -> None:
    assert gc.isenabled()
    try:
        if not is_enabled:
            gc.disable()
        with uncollected():
            assert not gc.isenabled()
            with uncollected():
                pass
            assert not gc.isenabled()
        assert gc.isenabled() is is_enabled
    finally:
        gc.enable()


def test_what_the_block_makes_is_not_looked_through_again() -> None:
    with uncollected():
        made: list[list[int]] = [[] for _ in range(1000)]
    tracked = {id(each) for each in gc.get_objects()}
    assert not any(id(each) in tracked for each in made)


def test_the_collector_goes_on_after_an_error() -> None:
    with pytest.raises(ZeroDivisionError), uncollected():
        raise ZeroDivisionError
    assert gc.isenabled()
