"""The options by which every command learns how to read loops and trajectories that are not in the project's own columns."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from measure.common.inputs import number

if TYPE_CHECKING:
    from measure.readers.column_mapping import ColumnMapping


def add_reading_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Put the group of these options into a parser; `mapping_from` makes a mapping of what was given."""
    read = parser.add_argument_group("reading loops and foreign trajectories")
    read.add_argument(
        "--column", action="append", default=[], metavar="QUANTITY=NAME", help="column of time, elongation or force, by name or number"
    )
    read.add_argument(
        "--unit", action="append", default=[], metavar="QUANTITY=UNIT", help="its unit, such as kN, mm, ms, V*0.05; position and angle too"
    )
    read.add_argument("--delimiter", help="tab, semicolon, comma, bar or space; found if not given")
    read.add_argument("--decimal", help="point or comma; found if not given")
    read.add_argument("--encoding", help="found if not given")
    read.add_argument("--no-header", action="store_true", help="the first row is data")
    read.add_argument("--sample-period", type=number(), metavar="SECONDS", help="where the file holds no time")
    read.add_argument("--name-pattern", metavar="PATTERN", help='conditions in the file names, such as "KDN_{pressure_bar}bar"')
    read.add_argument("--sheet", metavar="NAME", help="of a workbook; needed where several sheets hold a table")
    read.add_argument("--up", metavar="AXIS", help="of a file of markers: the axis that points up, x, y, z; --up=-z for the other way")
    read.add_argument("--across", metavar="AXIS", help="of a file of markers: the axis that becomes x_m (x, or y where x points up)")
    read.add_argument("--markers", metavar="A,B,C", help="of a file of markers: those on the platform (all)")
    read.add_argument("--mapping", type=Path, metavar="FILE", help="all of the above from a file; options given beside it win")
    return read


def mapping_from(given: argparse.Namespace) -> ColumnMapping:
    """The mapping file, if one was named, with the options given beside it put over it.

    Raises
    ------
    InputError
        A mapping file or an option that cannot be used.
    """
    from dataclasses import replace

    from measure.readers.column_mapping import ColumnMapping, pairs, read_mapping

    base = read_mapping(given.mapping) if given.mapping else ColumnMapping()
    single = {
        "delimiter": given.delimiter,
        "decimal": given.decimal,
        "encoding": given.encoding,
        "header": False if given.no_header else None,
        "sample_period_s": given.sample_period,
        "name_pattern": given.name_pattern,
        "sheet": given.sheet,
        "up": given.up,
        "across": given.across,
        "markers": tuple(name.strip() for name in given.markers.split(",")) if given.markers is not None else None,
    }
    columns = {**base.columns, **pairs("--column", given.column)}
    units = {**base.units, **pairs("--unit", given.unit)}
    return replace(base, columns=columns, units=units, **{key: value for key, value in single.items() if value is not None})
