"""Colours for what stops a mechanism."""

from __future__ import annotations

from collections.abc import Iterable

# Okabe and Ito's colours, then paler ones of the same hues.
_COLOURS = (
    *("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#999999"),
    *("#7FB8D8", "#EAAE7F", "#7FCEB9", "#E5BCD3", "#F2CF7F", "#AAD9F4", "#CCCCCC"),
)


def colours_of(words: Iterable[str]) -> dict[str, str]:
    """A colour for each thing that stops something, in order of appearance; none for ""."""
    known = [each for each in dict.fromkeys(words) if each]
    return {each: _COLOURS[k % len(_COLOURS)] for k, each in enumerate(known)}
