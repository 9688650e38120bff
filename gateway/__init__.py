"""The gateway: one robot on a serial port becomes one robot on the bus."""
