"""What the project costs and how well it keeps time: `python -m benchmarks --help`."""
