"""Names in a look-up table file, shared by its writer and its reader."""

from __future__ import annotations

from trackctl.lut.table import VARIABLES, Status

FILETYPE = "trackctl-lut"
VERSION = 1
CONVENTIONS = "CF-1.11"

#: Coordinates in the order of the variables' dimensions, with unit and long name.
COORDINATES = {
    "slope": ("rad", "slope angle"),
    "velocity": ("m/s", "speed of the mass centre"),
    "curvature": ("1/m", "yaw rate over speed, positive in a left turn"),
    "heading": ("rad", "angle from the up-slope direction to the body x axis, counter-clockwise"),
}
RADIUS = "radius"
RADIUS_ATTRIBUTES = {"units": "m", "long_name": "turn radius, positive to the left, infinite when straight"}
#: Attribute of heading: 1 if the nodes go round the full circle, so that the last is followed by the first.
PERIODIC = "periodic"

STATUS = "status"
STATUS_LONG_NAME = "what became of the cell; unless converged, only the residual is a number"
FLAG_MEANINGS = " ".join(status.name.lower() for status in Status)

#: Type of each variable over all coordinates.
DTYPES = {**dict.fromkeys(VARIABLES, "<f8"), STATUS: "|u1"}

VEHICLE_PROFILE = "vehicle_profile"
TERRAIN_PROFILE = "terrain_profile"
GRAVITY = "gravity"
SENSITIVITY = "sensitivity"
