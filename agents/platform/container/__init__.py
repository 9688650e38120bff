"""The container: the process that agents live in, what it gives them, and how it is controlled from outside."""
