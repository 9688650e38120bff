"""The `acromovi` command, which ties the rooms together."""
