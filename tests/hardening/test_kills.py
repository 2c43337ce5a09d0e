"""`compute-lut` killed again and again at random moments: what it leaves, the next run goes on from."""

import subprocess
import sys

from patience import PATIENCE
from systems import needs_fork

#: Each run is a child of one warm process; whichever step it is in, a kill may meet it.
KILLS = """
import os, random, signal, sys, time
from dataclasses import replace
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from table_runs import compiled, request
from trackctl.lut.sweep import Seeding

folder, chance = Path(sys.argv[2]), random.Random(0)
asked = replace(request(), seeding=Seeding.PSO)
compiled(folder / "whole.h5", asked)  # with what is done once for a process: it is not in the time of the next
begun = time.monotonic()
compiled(folder / "again.h5", asked)
took = time.monotonic() - begun
output, killed = folder / "lut.h5", 0
for run in range(100):
    child = os.fork()
    if child == 0:
        compiled(output, asked, resume=True)
        os._exit(0)
    if killed < 6:
        time.sleep(chance.uniform(0.0, 0.6) * took)
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        killed += 1
    elif killed < 6:
        assert status == 0
        output.unlink()
    else:
        assert status == 0
        break
print(killed, output.read_bytes() == (folder / "whole.h5").read_bytes())
"""


@needs_fork
def test_killed_at_random_moments_it_goes_on_to_the_same_bytes(tmp_path, request):
    words = (str(request.config.rootpath / "tests"), str(tmp_path))
    run = subprocess.run([sys.executable, "-c", KILLS, *words], capture_output=True, text=True, timeout=PATIENCE)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == ["6", "True"]
    left = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".trackctl-")}
    assert left == {"whole.h5", "again.h5", "lut.h5"}
