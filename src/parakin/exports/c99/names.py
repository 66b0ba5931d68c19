"""Names and comments in C, made from a mechanism's."""

from __future__ import annotations

import re
from dataclasses import dataclass

from parakin.version import __version__

MADE_BY = f"Made by parakin {__version__}. Do not edit; export the mechanism again instead."


def identifier(text: str) -> str:
    """`text` as an identifier in C."""
    made = re.sub(r"\W", "_", text, flags=re.ASCII)
    return made if re.match(r"[A-Za-z]", made) else f"m{made}"


def unused(label: str, used: set[str]) -> str:
    """A label that is not yet used, and now is: with underscores where it has to differ."""
    while label in used:
        label += "_"
    used.add(label)
    return label


def comment(text: str) -> str:
    """`text` so that it does not end a comment."""
    return text.replace("*/", "* /").replace("/*", "/ *")


@dataclass(frozen=True)
class Names:
    """What the files (`stem`.c, `stem`.h) and all that they define are called."""

    stem: str

    @property
    def prefix(self) -> str:
        """Of functions and types."""
        return identifier(self.stem)

    @property
    def constant(self) -> str:
        """The prefix of constants."""
        return self.prefix.upper()
