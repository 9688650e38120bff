"""Fetch: a robot finds a coloured object, grips it, and brings it to a place.

acromovi run fetch robot=bart colour=red place=[1,0.5]
acromovi promote fetch robot=bart colour=red place=[1,0.5]
acromovi ask fetch@apps status

`application` runs it on a team; `cycle` is one step from readings to orders, without bus and clock. It is made of what
the camera sees (`sight`, `objects`), ways over the floor (`floor`), gripper or arm (`hands`) and what to do next
(`fetcher`). `settings.toml` has all settings, `arm.toml` those that differ for an arm. docs/fetch.md describes them.
"""
