"""What commands take: parameters that mean nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from linkage import Refusal

from parakin.cli.main import main

RIG = str(Path(__file__).parents[2] / "examples" / "rig.toml")


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("r", "--set: found 'r'; expected NAME=VALUE"),
        ("=3", "--set: found '=3'; expected NAME=VALUE"),
        ("r=", "--set: found 'r='; expected NAME=VALUE"),
        ("r= ", "--set: found 'r= '; expected NAME=VALUE"),
        ("", "--set: found ''; expected NAME=VALUE"),
        (
            "reech=3",
            "parameters: found unknown parameter 'reech'; expected one of: l, r, reach; di",
        ),
        ("r=3 K", "parameters.r: found '3 K': 'K' is not a unit of length"),
        ("r=nan", "parameters.r: found 'nan': unknown parameter 'nan'"),
        ("r=3 deg", "parameters.r: found '3 deg', an angle; expected a length"),
        ("reach=r*l", "parameters.reach: found 'r*l', a quantity in m^2; expected a length"),
        ("l=3", "cannot be assembled from its guess"),
        ("r=l=2", "parameters.r: found 'l=2': it cannot be parsed"),
        ("r=reach", "parameters.r: found the cycle r -> reach -> r"),
        ("r=open('x')", "parameters.r: found \"open('x')\": unknown function 'open'"),
    ],
)
def test_a_setting_that_means_nothing(setting: str, said: str, refusal: Refusal) -> None:
    assert said in refusal("check", "linkage.toml", "--set", setting)


@pytest.mark.parametrize(
    "command",
    [
        ["range", RIG],
        ["workspace", RIG, "--over", "platform.x,platform.z", "--points", "9"],
        ["modes", RIG, "--starts", "1"],
    ],
)
def test_what_is_likely_a_slip_of_units_is_told_once(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    for setting, warned in [("cone=25", 1), ("cone=25 deg", 0), ("cone=0.4", 0)]:
        main([*command, "--set", setting])
        err = capsys.readouterr().err
        assert err.count("warning") == warned
        assert ("Perhaps '25 deg' was meant" in err) == bool(warned)


def test_millimetres_without_a_unit_are_told_too(capsys: pytest.CaptureFixture[str]) -> None:
    settings = ["r_base=820", "r_platform=610", "leg_min=860", "leg_max=1260"]
    main(["range", RIG, *(text for setting in settings for text in ("--set", setting))])
    assert "warning: lengths without a unit are metres" in capsys.readouterr().err


def test_a_check_warns_in_its_report_alone(capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", RIG, "--set", "cone=25"])
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.count("Perhaps '25 deg' was meant") == 1


def test_of_what_cannot_be_assembled_the_slip_is_told_first(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["range", RIG, "--set", "cone=25", "--set", "r_base=9"]) == 2
    warning, error = capsys.readouterr().err.splitlines()
    assert warning.startswith("warning: angles without a unit")
    assert "cannot be assembled" in error


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["range", RIG, "--from", "x=1 m"], "--from: found 'x', which is not driven; expected one"),
        (["range", RIG, "--with", "P1=1 m"], "--with: found 'P1', which is not driven"),
        (["workspace", RIG, "--within", "x=0..1"], "--within: found 'x', which is not driven"),
    ],
)
def test_a_name_that_is_not_driven_is_told_what_is(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(options) == 2
    err = capsys.readouterr().err
    assert message in err
    assert "expected one of: platform.pitch, platform.roll, platform.x" in err
