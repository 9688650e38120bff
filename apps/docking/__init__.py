"""Docking: a robot drives onto its charging dock, is charged, and leaves it.

acromovi run docking robot=max dock=[0.7,9.3,3.14]
acromovi run docking robot=max dock=[0.7,9.3,3.14] below=0.3
acromovi run docking robot=max leave=true

`application` runs it on a team; `cycle` decides, without bus and clock; `station` finds the station in a laser scan;
`settings.toml` has all settings. docs/docking.md describes them.
"""
