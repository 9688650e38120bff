"""The upper layer: agents that watch over others and work for applications."""
