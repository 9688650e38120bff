"""Agents that work on the pictures of a robot's camera: vision, colours, flow, motion.

They live as long as the camera. OpenCV (extra `vision`) is loaded with the first image that one of them works on: the
modules `*_tools` import it, and only the threads of the agents import them.
"""
