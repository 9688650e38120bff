"""The agents: each hears, lets an algorithm reckon, and pushes what comes out."""
