"""What happens after an exception that nobody foresaw: one sentence, and a file that can be sent to the developers."""

from __future__ import annotations

import platform
import sys
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path

FAULT = 70  # EX_SOFTWARE of sysexits.h


def report_of(name: str, arguments: Sequence[str], error: BaseException) -> str:
    """The text of the file: command, versions, traceback; no data of the user but the words of the command line.

    Parameters
    ----------
    name, arguments : the command and the words behind it.
    error : what was raised.
    """
    lines = [
        "A fault of unspool. Please report it with this file, and with the input files if you may share them.",
        "",
        f"command   {' '.join([name, *arguments])}",
        f"system    {platform.platform()}, Python {platform.python_version()}",
        f"versions  {', '.join(_versions())}",
        "",
        *traceback.format_exception(error),
    ]
    return "\n".join(lines)


def _versions() -> list[str]:
    """The program and the libraries it is built on, each with its version."""
    import re
    from importlib import metadata

    from measure.common.version import versions_of

    try:
        needed = [re.split(r"[ \[<>=!~;]", entry)[0] for entry in metadata.requires("unspool") or () if "extra ==" not in entry]
    except metadata.PackageNotFoundError:
        return ["unknown"]
    return [f"{package} {version}" for package, version in versions_of(("unspool", *needed)).items()]


def sentence_of(name: str, arguments: Sequence[str], error: BaseException) -> str:
    """What is said, once the file has been written: here, or among the temporary files where this folder cannot be written."""
    text = report_of(name, arguments, error)
    for folder in (Path(), Path(tempfile.gettempdir())):
        try:
            with tempfile.NamedTemporaryFile(
                "w", prefix=f"{name.replace(' ', '-')}-fault-", suffix=".txt", dir=folder, delete=False, encoding="utf-8"
            ) as file:
                file.write(text)
        except OSError:
            continue
        kept = file.name if folder != Path() else Path(file.name).name
        return f"{name}: a fault of the program ({type(error).__name__}), not of your input. Please report it with the file {kept}."
    sys.stderr.write(text)
    return f"{name}: a fault of the program ({type(error).__name__}). Please report what stands above; no file could be written."
