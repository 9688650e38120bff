"""What decides, without bus and clock: ways, tours, bids, neglect, changes in readings, and intruders."""
