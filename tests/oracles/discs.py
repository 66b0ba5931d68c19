"""Areas of what lies in some discs and outside of others, in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def turned(angle: np.ndarray | float) -> np.ndarray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def area_of_rings(rings: Sequence[tuple[np.ndarray, float, float]]) -> float:
    """Of what is in all rings: half the integral of x dy - y dx along the arcs that bound it."""
    circles = [(c, high, 1.0) for c, _, high in rings] + [(c, low, -1.0) for c, low, _ in rings]

    def within(point: np.ndarray, but: int) -> bool:
        distances = [np.linalg.norm(point - c) for c, *_ in circles]
        return all(
            sign * (r - d) > 0.0
            for k, (d, (_, r, sign)) in enumerate(zip(distances, circles, strict=True))
            if k != but
        )

    total = 0.0
    for k, (centre, r, sign) in enumerate(circles):
        meets = [-np.pi, np.pi]
        for other, s, _ in circles:
            way = other - centre
            d = float(np.linalg.norm(way))
            if abs(r - s) < d < r + s:
                half = np.arccos((d * d + r * r - s * s) / (2.0 * d * r))
                to = np.arctan2(way[1], way[0])
                meets += [(to + e + np.pi) % (2.0 * np.pi) - np.pi for e in (half, -half)]
        for a, b in zip(sorted(meets)[:-1], sorted(meets)[1:], strict=True):
            if within(centre + r * turned(0.5 * (a + b)), k):
                x, y = centre
                arc = x * (np.sin(b) - np.sin(a)) - y * (np.cos(b) - np.cos(a))
                total += 0.5 * sign * (r * r * (b - a) + r * arc)
    return total
