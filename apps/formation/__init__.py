"""Formation: followers keep their places in a shape round a leader that anybody drives.

acromovi run formation leader=happy followers=doc,grumpy shape=triangle starts=my-team.toml
acromovi promote formation leader=happy followers=doc,grumpy starts=my-team.toml
acromovi ask formation@apps shape shape=line

`application` runs it on a team; `controller` is the algorithm, without bus and clock; `settings.toml` has all settings.
docs/formation.md describes them.
"""
