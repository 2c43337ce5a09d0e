"""``trackctl profiles``: the vehicle and terrain profiles."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from trackctl.cli import options
from trackctl.cli.registration import add_command, help_texts
from trackctl.errors import ProfileError, TrackctlError
from trackctl.files.profile_folders import ProfileKind


def list_(as_json: options.Json = False) -> None:
    """The vehicles and terrains that have a name, with a line on each.

    Those in the folders of $TRACKCTL_PROFILE_PATH come before shipped ones of the same name.

    Example:
      trackctl profiles list
    """
    from trackctl.files.profile_yaml import list_profiles

    listed = {kind.folder: list_profiles(kind) for kind in ProfileKind}
    if as_json:
        rows = {
            folder: [{"name": row.name, "path": str(row.path), "description": row.description} for row in profiles]
            for folder, profiles in listed.items()
        }
        typer.echo(json.dumps(rows))
        return
    width = max(len(row.name) for profiles in listed.values() for row in profiles)
    for folder, profiles in listed.items():
        typer.echo(f"{folder}:")
        for row in profiles:
            typer.echo(f"  {row.name:<{width}}  {' '.join(row.description.split())}")


def show(
    profile: Annotated[
        str,
        typer.Argument(metavar="NAME|FILE", autocompletion=options.complete_profile, help="- reads stdin."),
    ],
) -> None:
    """The file of a profile, as it is, with the origin of each value.

    Example:
      trackctl profiles show utv-61cm
    """
    from trackctl.files.profile_yaml import parse_profile, read_profile

    text, file = read_profile(profile, *ProfileKind)
    parse_profile(text, file)
    typer.echo(text, nl=False)


def check(
    profiles: Annotated[
        list[str],
        typer.Argument(metavar="NAME|FILE...", autocompletion=options.complete_profile, help="- reads stdin."),
    ],
) -> None:
    """Check that files are vehicle or terrain profiles.

    All are checked, even after one with an error.

    Example:
      trackctl profiles show m113 | trackctl profiles check -
    """
    from trackctl.files.profile_yaml import kind_of_profile, parse_profile, read_profile

    faults = []
    for name_or_path in profiles:
        try:
            text, file = read_profile(name_or_path, *ProfileKind)
            profile = parse_profile(text, file)
        except ProfileError as error:
            faults.append(str(error))
        else:
            typer.echo(f"{file}: ok, {kind_of_profile(profile)} {profile.name}")
    if faults:
        raise TrackctlError("\n".join(faults))


def new(
    kind: Annotated[ProfileKind, typer.Argument(help="What to describe.", show_default=False)],
    output: options.Output = None,
    force: options.Force = False,
) -> None:
    """A commented profile to fill in, with the values of the default one.

    Example:
      trackctl profiles new vehicle -o my-vehicle.yaml
    """
    from trackctl.files.atomic import write_text
    from trackctl.files.profile_yaml import load_terrain, load_vehicle, profile_template

    if kind is ProfileKind.VEHICLE:
        text = profile_template(load_vehicle(options.DEFAULT_VEHICLE))
    else:
        text = profile_template(load_terrain(options.DEFAULT_TERRAIN))
    if output is None or str(output) == "-":
        typer.echo(text, nl=False)
        return
    write_text(output, text, force)


GROUP_HELP = """Vehicle and terrain profiles.

A profile is a flat YAML file, every key with its unit.
A NAME is such a file shipped with trackctl or in a folder of $TRACKCTL_PROFILE_PATH.

Example:
  trackctl profiles show asphalt
"""
app = typer.Typer(no_args_is_help=True, rich_markup_mode=None, **help_texts(GROUP_HELP))  # type: ignore[arg-type]
for command in (list_, show, check, new):
    add_command(app, command)
