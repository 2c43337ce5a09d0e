"""Small tables compiled through the Python function, whole or stopped on the way."""

from dataclasses import replace

import numpy as np

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.grid import default_ranges
from trackctl.workflows.compute_lut import compute_lut
from trackctl.workflows.provenance import Provenance
from trackctl.workflows.table_request import new_request
from trackctl.workflows.table_steps import explicit_steps

VEHICLE = load_vehicle("utv-61cm")
RANGES = replace(default_ranges(VEHICLE), velocity=(0.5, 1.5), radius=(1.0, 6.0))
STEPS = explicit_steps(RANGES, 0.5, 1.0, np.radians(30.0))


def request(terrain="asphalt", slope_deg=12.0, vehicle=VEHICLE):
    asked = new_request(vehicle, load_terrain(terrain), 9.81, np.radians([slope_deg]), RANGES, "continuation", 0)
    return asked.divided(STEPS.divisions)


def compiled(output, asked=None, jobs=1, resume=False, force=False, progress=lambda done, total: None, crew=None):
    made = Provenance("then", "so")
    settings = {"jobs": jobs, "resume": resume, "force": force, "progress": progress, "crew": crew}
    return compute_lut(asked or request(), STEPS, output, made, **settings)


class StoppedError(Exception):
    pass


def stop_after(columns):
    def progress(done, total):
        if done >= columns:
            raise StoppedError

    return progress
