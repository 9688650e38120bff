"""Algorithms on camera images: operations and chains of them, colour blobs, motion, optical flow, pose of a target.

Arrays and numbers in, arrays and numbers out: no bus, no port, no clock. The modules load numpy and OpenCV (extra
`vision`), so a program imports them where it uses them and not when it starts. This file loads nothing.
"""
