"""Sweeps: equal results with any number of workers, scaling, overhead of a run, memory, and the search for a failure.

    python benchmarks/sweeps.py [--seed 1] [--runs 300] [--seeds 10] [--memory 10000] [--cluster]

The pinch is a button pressed in the 6 ms of a minute in which a table passes a place: one run of 10,000 at random.  The
overhead of a run is processor time, as other programs also use the processor.  Exit code 1 if a goal is missed.
"""

import argparse
import random
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, process_time, sleep

from axistwin.bench.programs.command_lines import run_until_quiet
from axistwin.sweeps import BOUND_NS, Design, Sweep, Workers, digest, read

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
SCALING, OVERHEAD_MS, KILLS, MEMORY_MB, ROUNDS = 0.9, 3.0, 10, 50, 5
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


def timed(directory: Path, runs: int, workers: int) -> tuple[float, str]:
    """Return the real time of all runs after the start, and the hash of the results."""
    made = study(directory, runs)
    runner, points = made.check()
    with Workers(runner, workers) as engine:
        list(engine.map(enumerate(points[: 2 * workers])))
        begin_s = perf_counter()
        list(engine.map(enumerate(points)))
        whole_s = perf_counter() - begin_s
    return whole_s, digest(made.run(workers=workers))


def processor_s() -> float:
    """Return the processor time of this process and of all its processes that have ended."""
    spent = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in spent)


def swept_s(directory: Path, runs: int) -> float:
    """Return the processor time of a sweep with two workers, from the points to the Parquet file."""
    begin_s = processor_s()
    study(directory, runs).run(directory / "cost.parquet", workers=2)
    (directory / "cost.parquet").unlink()
    return processor_s() - begin_s


def bare_ms(directory: Path, runs: int) -> float:
    """Return the processor time of a run by itself, from the first event to the last, in ms."""
    runner, points = study(directory, runs).check()
    benches = [runner.variation.scene(values).build() for values in points]
    begin_s = process_time()
    for bench in benches:
        run_until_quiet(bench, BOUND_NS)
    return (process_time() - begin_s) / runs * 1e3


def overhead_ms(directory: Path) -> tuple[float, float]:
    """Return the processor time of a run by itself, and that of a sweep for each run beyond it, in ms.

    The second includes the scene with its values, recording, measures, messages and rows, in all processes.  The start
    of the processes is left out: it is the same for any number of runs.  Each time is the least of several, because
    other programs slow down a processor that they share.
    """
    few, many = 100, 700
    rounds = [(bare_ms(directory, few), swept_s(directory, few), swept_s(directory, many)) for _ in range(ROUNDS)]
    bare, few_s, many_s = (min(column) for column in zip(*rounds, strict=True))
    return bare, (many_s - few_s) / (many - few) * 1e3 - bare


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
        one_s, first = timed(directory, given.runs, 1)
        two_s, second = timed(directory, given.runs, 2)
        bare, more_ms = overhead_ms(directory)
        share = (one_s / two_s) / (control(2) / control(1))
        third = killed(directory, given.runs, random.Random(given.seed))
        goals["equal tables with 1 and 2 workers and after kills"] = len({first, second, third}) == 1
        goals[f"scaling {share:.2f} of a control loop's: at least {SCALING}"] = share >= SCALING
        goals[f"overhead {more_ms:.2f} ms a run of {bare:.2f} ms: at most {OVERHEAD_MS}"] = more_ms <= OVERHEAD_MS
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
