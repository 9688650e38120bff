"""The algorithms of the components: pure functions of readings and time, without bus, clock and asyncio."""
