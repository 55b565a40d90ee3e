"""What may not happen, whatever a command is given; and how many tries of a kind are made."""

from __future__ import annotations

import os
import random
import shutil
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

MOST_MB = 300  # of memory where an input is refused, beside the 200 that a command has when all is loaded
MOST_S = 5.0  # of processor time, likewise
SECRET = "SECRETSECRET"
LARGE = 10**7


def tree(folder):
    """Every file with its content; what is no file, and what is too large to be read, by its kind and size."""
    found = {}
    for path in sorted(folder.rglob("*")):
        seen = path.lstat()
        plain = path.is_file() and not path.is_symlink() and seen.st_size < LARGE
        found[os.fsencode(path.relative_to(folder))] = path.read_bytes() if plain else (seen.st_mode, seen.st_size)
    return found


def restored(folder, before):
    """Take away what has come, and give back what has gone or changed."""
    for name, content in tree(folder).items():
        path = folder / os.fsdecode(name)
        if name in before:
            if isinstance(content, bytes) and content != before[name]:
                path.write_bytes(before[name])
        elif path.exists() or path.is_symlink():
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    for name, content in before.items():
        path = folder / os.fsdecode(name)
        if isinstance(content, bytes) and not path.exists():
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)


@dataclass
class Tally:
    """How many tries ended how, and a sentence on each that went wrong."""

    counts: Counter = field(default_factory=Counter)
    wrong: list = field(default_factory=list)
    longest_s: float = 0.0
    largest_mb: float = 0.0
    at_end: Callable[[Tally], object] = lambda counted: None

    def end(self):
        """Hand over what was counted; fails where something went wrong."""
        self.at_end(self)
        assert not self.wrong, "\n".join(self.wrong)

    def judge(self, commands, folder, words, inputs=(), **how):
        """Run a command and look at what it leaves; the folder is as before afterwards."""
        before = tree(folder)
        ended = commands.run(words, folder, **how)
        after = tree(folder)
        self.counts["tries"] += 1
        self.counts[f"status {ended.status}" if ended.status in (0, 1, 2) else "other"] += 1
        kept = {os.fsencode(path.relative_to(folder)) for path in inputs}
        said = [
            ("traceback", ended.status not in (0, 1, 2, 124)),
            ("no end", ended.status == 124),
            ("files left at status 2", ended.status == 2 and after != before),
            ("inputs destroyed", any(after.get(name) != before.get(name) for name in kept)),
            ("no sentence", ended.status == 2 and not (ended.error or ended.out).strip()),
            ("control characters", any(ord(letter) < 32 and letter != "\n" for letter in ended.error + ended.out)),
            ("echoed", SECRET in ended.error + ended.out),
            ("refused late or at great cost", ended.status == 2 and (ended.processor_s > MOST_S or ended.memory_mb > MOST_MB)),
        ]
        if ended.status == 2:
            self.longest_s, self.largest_mb = max(self.longest_s, ended.processor_s), max(self.largest_mb, ended.memory_mb)
        for kind, is_so in said:
            self.counts[kind] += is_so
            if is_so:
                shown = " ".join(map(repr, map(str, words)))
                self.wrong.append(
                    f"{kind}: {shown}: {ended.status}, {ended.processor_s:.1f} s, {ended.memory_mb:.0f} MB {ended.error[-400:]!r}"
                )
        restored(folder, before)
        return ended

    def row(self, kind):
        """For the table of the validation."""
        names = ("tries", "traceback", "no end", "files left at status 2", "inputs destroyed")
        measured = {"longest refusal, s": self.longest_s, "largest, MB": self.largest_mb}
        return {"tried": kind, **{name: self.counts[name] for name in names}, "refused": self.counts["status 2"], **measured}


def counts(full):
    """A few each time, and all of them where a calibration asks: how many, and the seed."""
    return [pytest.param(max(4, full // 60), 1, id="few"), pytest.param(full, None, id="all", marks=pytest.mark.calibrate)]


def chances(kind, full, seed, share_of, calibration_seed):
    """A source of chance for each try, so that one can be made again alone."""
    number, drawn = (full, seed) if seed is not None else (share_of(full), calibration_seed)
    return [random.Random(f"{kind} {drawn} {k}") for k in range(number)]
