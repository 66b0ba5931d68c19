"""Options that several commands have."""

from __future__ import annotations

import argparse


def number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text!r}; expected a number") from None


def add_settings(
    command: argparse.ArgumentParser,
    flag: str,
    does: str,
    *,
    dest: str | None = None,
    metavar: str = "NAME=VALUE",
) -> None:
    """An option that may be given several times, by name."""
    command.add_argument(flag, dest=dest, metavar=metavar, action="append", default=[], help=does)


def add_least_conditioning(command: argparse.ArgumentParser) -> None:
    text = "how near to a singularity it may come, home being 1"
    command.add_argument("--least-conditioning", metavar="PART", type=number, help=text)


def add_payload(command: argparse.ArgumentParser) -> None:
    text = "a mass on a body, e.g. --payload '80 kg at seat'"
    add_settings(command, "--payload", text, metavar="TEXT")


def add_driven(
    command: argparse.ArgumentParser, what: str, default: str = "the file's own by default"
) -> None:
    text = f"{what}, separated by commas; {default}"
    command.add_argument("--driven", metavar="NAMES", help=text)


def add_mechanism(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "mechanism", metavar="MECHANISM", help="a catalogue name, or a TOML, MJCF or URDF file"
    )
    command.add_argument(
        "--loops", metavar="FILE", help="YAML file that specifies the loops of a URDF"
    )
    add_settings(command, "--set", "override a parameter, e.g. --set d1=0.42 or --set 'd1=420 mm'")
