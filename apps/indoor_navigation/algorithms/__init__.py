"""What the components reckon with: pure functions of readings and time. No bus, no clock, no asyncio."""
