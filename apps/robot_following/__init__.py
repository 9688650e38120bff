"""Robot following: a robot drives behind another one that carries a target of three coloured rectangles.

acromovi run robot_following robot=happy
acromovi run robot_following robots=happy,doc
acromovi promote robot_following robot=happy
acromovi ask robot_following@apps status

`application` runs it on a team; `cycle` is one step from readings to orders, without bus and clock. It is made of the
leader's motion from sightings (`sight`, `leader`), a cubic Bézier curve to it (`curve`), the speed that keeps the gap
(`follower`), and where the camera looks (`gaze`). `settings.toml` has all settings. docs/following.md describes them.
"""
