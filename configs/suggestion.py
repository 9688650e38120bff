"""Suggestions for misspelt words."""

import difflib
from collections.abc import Iterable

LONGEST = 80  # characters of a word that may be misspelt; a longer one is no word
MOST_NAMED = 3  # unknown words that an error names
LIKENESS = 0.6  # of `difflib`, from which on a word counts as misspelt


def meant(word: str, known: Iterable[str]) -> str:
    """Return the known word most similar to another one; empty when none is."""
    if len(word) > LONGEST:
        return ""
    near = difflib.get_close_matches(word, list(known), 1, LIKENESS)
    return near[0] if near else ""


def not_taken(name: str, unknown: Iterable[str], known: Iterable[str]) -> str:
    """Return the error for arguments that a command does not know.

    `move does not take 'distanc' (did you mean distance?); it takes distance, speed`.
    """
    takes = list(known)
    words = [word if len(word) <= LONGEST else f"{word[:LONGEST]}…" for word in unknown]
    named = ", ".join(f"{word!r}{hint(word, takes)}" for word in words[:MOST_NAMED])
    return f"{name} does not take {named}; it takes {', '.join(takes) or 'nothing'}"


def hint(word: str, known: Iterable[str]) -> str:
    """Return a suggestion in brackets, ` (did you mean distance?)`; empty when no known word is similar."""
    near = meant(word, known)
    return f" (did you mean {near}?)" if near else ""
