"""Values of SAY. Source: Pioneer 3 operations manual, and fact sheet section 4."""

NOTE_UNIT = 0.02
"""s that a count of a note's duration stands for."""
LONGEST_NOTE = 255 * NOTE_UNIT
"""s."""
MOST_NOTES = 20
HIGHEST_NOTE = 127
"""MIDI; 0 is a rest, and above are tones."""
TONE_STEP = 32.0
"""Hz from one tone above the MIDI notes to the next."""
