"""Faults by name: their effect on a robot, how they end, and the board that starts and ends them.

Every fault takes `robot=NAME`; without it, the fault is applied to every robot that can have it. All times are emulated
time.
"""
