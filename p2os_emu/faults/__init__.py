"""Faults by name: what each one does to a robot, how it ends, and the board that lets them come and go.

Every fault takes `robot=NAME`; without it, it befalls every robot that is there and can suffer it. All times are
emulated time.
"""
