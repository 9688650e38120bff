"""Applications: one folder each, on the bus alone, the same on emulated and real robots."""
