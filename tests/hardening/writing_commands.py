"""Every command that writes a file, on small inputs: a row here is tried on full disks and in closed folders."""

from dataclasses import dataclass

SMALL_TABLE = "--steps velocity=.5,radius=9,heading=60 --velocity-mps 0.5:1.5 --radius-m 1:19"


@dataclass(frozen=True)
class Writing:
    """A command line up to the option that names its output, the file's suffix, and what it needs to read."""

    words: str
    suffix: str = ".csv"
    option: str = "--output"

    def line(self, inputs, output):
        filled = self.words.format(**inputs)
        return [*filled.split(), self.option, str(output)]


#: C has two files, tried in `test_atomic`.
COMMANDS = {
    "compute-lut": Writing(f"compute-lut {SMALL_TABLE} --jobs 1", ".h5"),
    "lookup": Writing("lookup {lut} {points}"),
    "export mat": Writing("export {lut}", ".mat"),
    "export npz": Writing("export {lut}", ".npz"),
    "sensitivity": Writing("sensitivity --samples 256 --jobs 1"),
    "sweep": Writing("sweep --slope-deg 3,5 --heading-deg 0:360:30 --jobs 1"),
    "simulate": Writing("simulate --track-speeds-mps 0.2,0.5 --duration-s 1"),
    "plan": Writing("plan {map} --iterations 20 --jobs 1"),
    "plan --plot": Writing("plan {map} --iterations 20 --jobs 1", ".png", "--plot"),
    "forces": Writing("forces"),
    "identify": Writing("identify {log} --vehicle utv-61cm"),
    "identify --save": Writing("identify {log} --vehicle utv-61cm", ".yaml", "--save"),
    "predict": Writing("predict {log} --vehicle utv-61cm --slip {slip}"),
    "calibrate": Writing("calibrate {log} --vehicle utv-61cm", ".yaml"),
    "plot": Writing("plot {sweep}", ".pdf"),
    "profiles new": Writing("profiles new vehicle", ".yaml"),
}
