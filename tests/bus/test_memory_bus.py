"""What only the bus in memory promises: everything has been delivered, in one order, when `put` returns."""

from bus import MemoryBus, MemoryNetwork, Sample


def test_a_put_returns_when_all_have_heard() -> None:
    network = MemoryNetwork()
    heard: list[str] = []
    MemoryBus(network).subscribe("happy/odom", lambda sample: heard.append("first"))
    MemoryBus(network).subscribe("happy/**", lambda sample: heard.append("second"))
    MemoryBus(network).put("happy/odom", {})
    assert heard == ["first", "second"]


def test_what_a_handler_puts_comes_after_what_was_put_before() -> None:
    bus = MemoryBus()
    heard: list[str] = []

    def relay(sample: Sample) -> None:
        heard.append(f"relay {sample.key}")
        if sample.key == "a/cause":
            bus.put("a/effect", {})

    def note(sample: Sample) -> None:
        heard.append(f"note {sample.key}")

    bus.subscribe("a/*", relay)
    bus.subscribe("a/*", note)
    bus.put("a/cause", {})
    assert heard == ["relay a/cause", "note a/cause", "relay a/effect", "note a/effect"]


def test_who_unsubscribes_during_a_delivery_is_not_called() -> None:
    bus = MemoryBus()
    heard: list[Sample] = []
    bus.subscribe("a/x", lambda sample: second.close())
    second = bus.subscribe("a/x", heard.append)
    bus.put("a/x", {})
    assert heard == []


def test_who_subscribes_later_hears_what_is_put_later() -> None:
    bus = MemoryBus()
    early: list[str] = []
    late: list[str] = []
    bus.subscribe("a/x", lambda sample: early.append(sample.payload.decode()))
    bus.put("a/x", {"n": 1})
    bus.subscribe("a/*", lambda sample: late.append(sample.payload.decode()))
    bus.put("a/x", {"n": 2})
    assert (early, late) == (['{"n":1}', '{"n":2}'], ['{"n":2}'])


def test_networks_are_apart() -> None:
    heard: list[Sample] = []
    MemoryBus().subscribe("**", heard.append)
    MemoryBus().put("a/x", {})
    assert heard == []


def test_nothing_is_left_of_a_bus_that_closed() -> None:
    network = MemoryNetwork()
    bus = MemoryBus(network)
    bus.subscribe("a/x", lambda sample: None)
    bus.serve("a/q", lambda arguments: arguments)
    bus.declare_alive("a/alive")
    bus.watch_alive("**", lambda key, is_alive: None)
    bus.close()
    assert [network.subscribers, network.queryables, network.tokens, network.watchers] == [[], [], [], []]
