"""Surveillance: a team patrols the rooms of a building, and reports intruders.

acromovi run surveillance map=office.map
acromovi promote surveillance map=office.map robots=happy,doc

`application` is the program that people start; `patrol_manager` auctions the rooms and hears the alarms, beside the
program; `patrol_agent` drives and watches, beside the agents of each robot; `algorithms` decide, without bus and clock;
`settings.toml` has all settings. docs/surveillance.md describes them.
"""
