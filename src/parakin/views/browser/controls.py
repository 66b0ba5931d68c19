"""Small things that controls of a page need."""

from __future__ import annotations

import math
from typing import Any


def tell(control: Any, text: str) -> None:
    """Show a text, or nothing of an empty one."""
    if text or control.visible:
        control.content = text
        control.visible = bool(text)


def nearest_step(slider: Any, value: float) -> float:
    """The step of a slider nearest to a value."""
    low, high, step = float(slider.min), float(slider.max), float(slider.step)
    digits = max(0, -math.floor(math.log10(step)))
    at = round(low + step * round((value - low) / step), digits)
    return min(max(at, low), high)
