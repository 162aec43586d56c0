"""Sweeps: equal results with any number of workers, scaling, overhead of a run, memory, and the search for a failure.

    python benchmarks/sweeps.py [--seed 1] [--runs 300] [--seeds 10] [--memory 10000] [--cluster]

The pinch is a button pressed in the 6 ms of a minute in which a table passes a place: one run of 10,000 at random.
code 1 if a goal is missed.
"""

import argparse
import random
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, sleep

from axistwin.sweeps import Sweep, digest, read
from axistwin.sweeps.sweep import Design
from axistwin.sweeps.workers import Workers

SCENE = """
[[controller]]
model = "if2"
name = "table"
host = "go.if1"
[controller.axes.X]
motor = { torque = [[0, 1.2], [4000, 0.7], [8000, 0.3]], inertia = 3e-5 }
load = { torque = 0.15, inertia = 6e-5 }
[[script]]
at = 0.5
do = "input2 high"
"""
LINES = "".join(f"X{way}8000@4000$\n" for way in ("", "-", "", "-"))
SCALING, OVERHEAD_MS, KILLS, MEMORY_MB = 0.9, 3.0, 10, 50
CLAIM = "never table.input2 rises while table.X.position > 3997 and table.X.position < 4003"


def scene(directory: Path) -> Path:
    """Write the scene and the lines of its host; return the scene."""
    (directory / "go.if1").write_text(LINES)
    (directory / "scene.toml").write_text(SCENE)
    return directory / "scene.toml"


def study(directory: Path, runs: int) -> Sweep:
    """Return a sweep over the load of the table."""
    made = Sweep(scene(directory)).vary("table.X.load.torque", f"0.05..0.45:{runs}")
    return made.measure("lost", "final table.X.lost").measure("peak", "max table.X.velocity")


def killed(directory: Path, runs: int, chance: random.Random) -> str:
    """Run the command, kill it at random times, and continue the sweep."""
    out = directory / "killed.parquet"
    words = (sys.executable, "-m", "axistwin", "sweep", scene(directory), "--out", out, "--workers", "2")
    words += ("--vary", f"table.X.load.torque=0.05..0.45:{runs}", "--measure", "lost: final table.X.lost")
    words += ("--measure", "peak: max table.X.velocity")
    for _ in range(KILLS):
        with subprocess.Popen(list(map(str, words))) as program:
            sleep(chance.uniform(1.0, 4.0))
            program.kill()
    subprocess.run(list(map(str, words)), check=True)
    return digest(read(out))


def busy(seconds: float) -> int:
    """Return the number of rounds of a plain Python loop in this time."""
    end, count = perf_counter() + seconds, 0
    while perf_counter() < end:
        for _ in range(1000):
            count += 1
    return count


def control(processes: int) -> int:
    """Return the number of rounds of such loops in this number of processes."""
    loop = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); import sweeps; print(sweeps.busy(2.0))"
    running = [subprocess.Popen([sys.executable, "-c", loop], stdout=subprocess.PIPE) for _ in range(processes)]
    return sum(int(each.communicate()[0]) for each in running)


def timed(directory: Path, runs: int, workers: int) -> tuple[float, float, str]:
    """Return the real time of all runs after the start, the time within the runs, and the hash of the results."""
    made = study(directory, runs)
    runner, points = made.check()
    with Workers(runner, workers) as engine:
        list(engine.map(enumerate(points[: 2 * workers])))
        begin_s = perf_counter()
        rows = list(engine.map(enumerate(points)))
        whole_s = perf_counter() - begin_s
    return whole_s, sum(row["wall_s"] for row in rows), digest(made.run(workers=workers))


def memory(directory: Path, runs: int) -> float:
    """Return by how many MB the memory of this process changes during a sweep of runs of ten seconds; Linux only."""
    used: list[float] = []

    def note(done: int, *_: int) -> None:
        if done % 100 == 0:
            pages = int(Path("/proc/self/statm").read_text().split()[1])
            used.append(pages * resource.getpagesize() / 1e6)

    study(directory, runs).run(directory / "memory.parquet", seconds=10, workers=2, progress=note)
    return max(used) - min(used)


def clustered(directory: Path, runs: int) -> str:
    """Return the hash of the results of a Dask cluster with two workers."""
    from distributed import LocalCluster  # lazy import: the extra may be missing

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        return digest(study(directory, runs).run(scheduler=cluster.scheduler_address))


def found(directory: Path, seed: int, design: str) -> bool:
    """Return True if 500 runs of a search, or of drawn points, find the failure."""
    made = Sweep(scene(directory)).vary("script.0.at", "0.0..60.0").vary("table.X.load.torque", "0.05..0.3")
    made.claim("pinch", CLAIM)
    chosen = Design(seed=seed, search=500) if design == "search" else Design("random", 500, seed)
    return False in made.run(workers=2, seconds=60, design=chosen)["pinch"].to_pylist()


def main() -> int:
    """Run all measurements; print a verdict for each goal."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=300)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--memory", type=int, default=0, metavar="RUNS")
    parser.add_argument("--cluster", action="store_true")
    given = parser.parse_args()
    goals = {}
    with tempfile.TemporaryDirectory() as name:
        directory = Path(name)
        one_s, _, first = timed(directory, given.runs, 1)
        two_s, inside_s, second = timed(directory, given.runs, 2)
        overhead_ms = (2 * two_s - inside_s) / given.runs * 1e3
        share = (one_s / two_s) / (control(2) / control(1))
        third = killed(directory, given.runs, random.Random(given.seed))
        goals["equal tables with 1 and 2 workers and after kills"] = len({first, second, third}) == 1
        goals[f"scaling {share:.2f} of a control loop's: at least {SCALING}"] = share >= SCALING
        goals[f"overhead {overhead_ms:.2f} ms a run: at most {OVERHEAD_MS}"] = overhead_ms <= OVERHEAD_MS
        if given.cluster:
            goals["equal tables with a Dask cluster"] = clustered(directory, given.runs) == first
        if given.memory:
            change_mb = memory(directory, given.memory)
            goals[f"memory changes by {change_mb:.1f} MB in {given.memory:,} runs: at most {MEMORY_MB}"] = (
                change_mb <= MEMORY_MB
            )
        if given.seeds:
            searched = sum(found(directory, seed, "search") for seed in range(given.seeds))
            drawn = sum(found(directory, seed, "random") for seed in range(given.seeds))
            goals[f"pinch found by --search for {searched} of {given.seeds} seeds"] = searched >= 0.9 * given.seeds
            goals[f"pinch found by drawn points for {drawn} of {given.seeds} seeds"] = drawn <= 0.1 * given.seeds
    for goal, met in goals.items():
        print("met   " if met else "MISSED", goal)
    return 0 if all(goals.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
