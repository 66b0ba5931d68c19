"""Options of the commands about design: how far it goes, and where it can go."""

from __future__ import annotations

import argparse
from pathlib import Path

from parakin.cli.options import (
    add_driven,
    add_least_conditioning,
    add_mechanism,
    add_payload,
    add_settings,
)


def add_range_options(ranges: argparse.ArgumentParser) -> None:
    add_mechanism(ranges)
    add_driven(ranges, "coordinates to move", "the platform's by default, else the file's own")
    pose = "a position to count from other than home's: a quantity such as '20 mm'"
    add_settings(ranges, "--from", pose, dest="pose")
    offsets = "what a coordinate is moved by first, e.g. platform.pitch='10 deg'"
    add_settings(ranges, "--with", offsets, dest="offsets")
    ranges.add_argument("--pairs", action="store_true", help="coordinates in pairs too")
    ranges.add_argument("--frequency", metavar="HZ", help="the largest sines too, e.g. at '0.5 Hz'")
    _add_demands(ranges)
    ranges.add_argument("-o", "--output", metavar="FILE", type=Path, help="table: .csv or .nc")
    ranges.add_argument("--plot", metavar="FILE", type=Path, help="figure: .png, .svg or .pdf")


def add_workspace_options(space: argparse.ArgumentParser) -> None:
    add_mechanism(space)
    add_driven(space, "coordinates to drive", "the platform's by default, else the file's own")
    pose = "a position other than home's: a quantity such as '20 mm'"
    add_settings(space, "--from", pose, dest="pose")
    within = "what to look at of a coordinate, islands included"
    add_settings(space, "--within", within, metavar="NAME=LOW..HIGH")
    proportions = "of the largest box; a cube by default"
    add_settings(space, "--proportions", proportions, metavar="NAME=NUMBER")
    space.add_argument(
        "--over", metavar="NAMES", help="two or three coordinates to move; all by default"
    )
    space.add_argument(
        "--kind",
        metavar="KIND",
        help="constant-orientation, orientation or mixed (of slides, angles or both, told by what "
        "is moved), reachable or dexterous (with any, or all, of --orientations)",
    )
    space.add_argument(
        "--orientations",
        metavar="TEXT",
        help="e.g. 'platform.roll=-5 deg; platform.roll=5 deg, platform.pitch=3 deg'",
    )
    space.add_argument("--points", metavar="N", type=int, help="nodes along each side (201 or 49)")
    _add_demands(space)
    space.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="grid: .csv or .nc; surface: .stl"
    )
    space.add_argument("--plot", metavar="FILE", type=Path, help="figure: .png, .svg or .pdf")
    space.add_argument(
        "--lines",
        metavar="FIGURE",
        help="what the lines in a slice are of: stroke (left, by default), conditioning or effort",
    )


def add_certify_options(certify: argparse.ArgumentParser) -> None:
    add_mechanism(certify)
    add_driven(certify, "coordinates to drive", "the platform's by default, else the file's own")
    within = "both ends of a coordinate, e.g. platform.x='-50 mm..50 mm'; the others stay"
    add_settings(certify, "--within", within, metavar="NAME=LOW..HIGH")
    pose = "a position other than home's: a quantity such as '20 mm'"
    add_settings(certify, "--from", pose, dest="pose")
    velocity = "of coordinates, either way and all at once; limits of velocities count then"
    add_settings(certify, "--velocity", velocity, dest="velocities")
    add_least_conditioning(certify)
    certify.add_argument("--boxes", metavar="N", type=int, help="parts to look at (200,000)")
    certify.add_argument("-o", "--output", metavar="FILE", type=Path, help="table: .csv or .nc")


def _add_demands(command: argparse.ArgumentParser) -> None:
    """What else may stop it, besides limits of positions."""
    command.add_argument(
        "--forces", action="store_true", help="the drives' largest efforts are limits too"
    )
    add_payload(command)
    add_least_conditioning(command)
