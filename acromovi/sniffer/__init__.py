"""Messages between agents, listened to and drawn as sequence diagrams in text and SVG."""
