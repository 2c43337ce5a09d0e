"""Slope-steering tables, plans and forces for unmanned tracked vehicles.

From Python: the names below do what the commands do, on objects and arrays; each is loaded when it is first used.
SI units and radians throughout; heading is 0 up the slope and grows counter-clockwise, curvature is 1 / radius,
positive to the left and 0 straight ahead. Nothing is printed. What a user can mend is raised as a `TrackctlError`:
a `UsageError` names a parameter (or the command's option of the same meaning), an `InputFileError` file and line, a
`NoAnswerError` says that there is no answer.
"""

from __future__ import annotations

__version__ = "0.1.0"

# Checkers know the name; loading `typing` for it would take longer than all the rest.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from trackctl.api.motion import (
        Basis,
        CircleTarget,
        DriveCommands,
        FilterKind,
        ForcesPath,
        ForcesResult,
        IdentifyResult,
        Measured,
        SimulateResult,
        SlipModel,
        SpeedKind,
        SpeedRequest,
        State,
        Steering,
        TrackSpeeds,
        arc_path,
        clothoid_path,
        constant_speeds,
        identify,
        load_commands,
        load_path,
        nominal_forces,
        simulate,
    )
    from trackctl.api.planning import PlanCost, PlanningMap, PlanResult, load_map, plan
    from trackctl.api.profiles import TerrainProfile, VehicleProfile, load_terrain, load_vehicle
    from trackctl.api.tables import (
        CMethod,
        ExportFormat,
        ExportResult,
        LookupMethod,
        LookupResult,
        LookupStatus,
        LookupTable,
        Precision,
        Seeding,
        compile_table,
        export_table,
        open_table,
        solve_point,
    )
    from trackctl.errors import InputFileError, NoAnswerError, TrackctlError, UsageError

__all__ = [
    "Basis",
    "CMethod",
    "CircleTarget",
    "DriveCommands",
    "ExportFormat",
    "ExportResult",
    "FilterKind",
    "ForcesPath",
    "ForcesResult",
    "IdentifyResult",
    "InputFileError",
    "LookupMethod",
    "LookupResult",
    "LookupStatus",
    "LookupTable",
    "Measured",
    "NoAnswerError",
    "PlanCost",
    "PlanResult",
    "PlanningMap",
    "Precision",
    "Seeding",
    "SimulateResult",
    "SlipModel",
    "SpeedKind",
    "SpeedRequest",
    "State",
    "Steering",
    "TerrainProfile",
    "TrackSpeeds",
    "TrackctlError",
    "UsageError",
    "VehicleProfile",
    "arc_path",
    "clothoid_path",
    "compile_table",
    "constant_speeds",
    "export_table",
    "identify",
    "load_commands",
    "load_map",
    "load_path",
    "load_terrain",
    "load_vehicle",
    "nominal_forces",
    "open_table",
    "plan",
    "simulate",
    "solve_point",
]

if not TYPE_CHECKING:  # a checker would take any name for one of ours
    # The light ones first: a name is looked for until it is found.
    _MODULES = (
        "trackctl.errors",
        "trackctl.api.profiles",
        "trackctl.api.motion",
        "trackctl.api.planning",
        "trackctl.api.tables",
    )

    def __getattr__(name):
        """Load a name of `__all__` when it is first used."""
        from importlib import import_module

        if name in __all__:
            for module in map(import_module, _MODULES):
                if hasattr(module, name):
                    return globals().setdefault(name, getattr(module, name))
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__():
        """All names, loaded or not."""
        return sorted({*globals(), *__all__})
