"""The gateway: brings one robot on a serial port to the bus."""
