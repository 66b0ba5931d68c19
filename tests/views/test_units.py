"""Units: as they are written by hand."""

from __future__ import annotations

from parakin.views.units import unit_of


def test_lengths_and_angles_as_they_are_written() -> None:
    length, angle = unit_of(False), unit_of(True)
    assert length.plain(0.0125) == "12.5000 mm"
    assert angle.plain(3.141592653589793 / 6, ".1f", "/s") == "30.0 deg/s"
    assert length.typeset(-1e-9) == "0.000 mm"
    assert angle.typeset(0.7853981633974483, ".6g") == "45°"
