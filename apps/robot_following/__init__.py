"""Robot following: a robot drives behind another one that carries a target of three coloured rectangles.

`follower.py` joins the algorithms: the leader's motion from sightings (`leader.py`), a cubic Bézier curve to it
(`curve.py`), and where the camera looks (`gaze.py`). They are pure functions of readings and time; all lengths in
m, angles in rad, frames by REP 103 and 105.
"""
