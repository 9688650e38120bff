"""The `acromovi` command, which connects the packages."""
