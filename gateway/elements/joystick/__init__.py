"""The joystick."""
