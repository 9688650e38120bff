"""Optical-flow navigation: one robot wanders by what its camera sees, without any range sensor.

acromovi run optical_flow robot=bart
acromovi run optical_flow robot=bart page=8080
acromovi promote optical_flow robot=bart
acromovi ask optical_flow@apps status

`application` runs it on a team; `wanderer` decides, without bus and clock; `settings.toml` has all settings.
docs/optical-flow.md describes them.
"""
