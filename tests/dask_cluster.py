"""A Dask scheduler and its workers as a user starts them, on loopback."""

import json
import os
import subprocess
import sys
import time

from patience import PATIENCE


class Cluster:
    """Processes by name; all are killed at the end."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = {}

    def __enter__(self):
        file = self.folder / "scheduler.json"
        self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", file)
        until = time.monotonic() + PATIENCE
        while not file.exists() or not file.read_text().endswith("}"):
            assert time.monotonic() < until
            time.sleep(0.02)
        self.address = json.loads(file.read_text())["address"]
        return self

    def __exit__(self, *_):
        for name in list(self.processes):
            self.kill(name)

    def staff(self, *names):
        """Have these workers and no others: start the missing, kill the rest."""
        for name in self.processes.keys() - {"scheduler", *names}:
            self.kill(name)
        for name in names:
            if name not in self.processes:
                self.start_worker(name)

    def start_worker(self, name, *words):
        self.start("worker", self.address, "--no-nanny", "--nthreads", "1", "--name", name, *words, name=name)

    def start(self, kind, *words, name=None):
        command = [sys.executable, "-m", "dask", kind, *map(str, words), "--no-dashboard"]
        with (self.folder / f"{name or kind}.log").open("w") as log:
            self.processes[name or kind] = subprocess.Popen(
                command, stdout=log, stderr=log, cwd=self.folder, env=os.environ | {"DASK_TEMPORARY_DIRECTORY": "."}
            )

    def kill(self, name):
        """End a process as a crash does."""
        process = self.processes.pop(name)
        process.kill()
        process.wait()
