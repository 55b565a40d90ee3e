"""How long `--help` of each command takes beyond a bare start of Python; the aim is under 0.5 s.

.venv/bin/python tests/benchmarks/bench_help.py
"""

from __future__ import annotations

import subprocess
import sys
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REPEATS = 7


def best_s(code: str, *arguments: str) -> float:
    """The shortest of several starts, s: what is left when the machine is otherwise idle."""
    taken = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code, *arguments], check=True, stdout=subprocess.DEVNULL)
        taken.append(time.perf_counter() - start)
    return min(taken)


def main() -> None:
    bare = best_s("pass")
    print(f"{'python -c pass':<22}{1e3 * bare:8.0f} ms")
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    for name, entry in scripts.items():
        module, function = entry.split(":")
        more = best_s(f"from {module} import {function}; {function}(['--help'])") - bare
        print(f"{name:<22}{1e3 * more:8.0f} ms more")


if __name__ == "__main__":
    main()
