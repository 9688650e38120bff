"""Buzzer or loudspeaker."""
