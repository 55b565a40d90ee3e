"""Loops out of LabVIEW's and MATLAB's newer files: the numbers that were written, or one sentence."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from measure import InputError
from measure.readers.column_mapping import ColumnMapping
from measure.readers.formats import guarded
from measure.readers.loop_file import read_loop_file
from measure.readers.stated_conditions import Claim

T = np.arange(40) * 0.5
U = np.round(12.0 * np.sin(0.3 * T), 3)
F = np.round(2.8 + 0.1 * np.cos(0.3 * T), 4)
NAMED = ColumnMapping({"elongation": "Laser", "force": "Load"}, {"elongation": "mm", "force": "N"})


def check(path, mapping=NAMED, time=T):
    loop, understood = read_loop_file(path, mapping)
    assert loop.time_s == pytest.approx(time)
    assert loop.elongation_m == pytest.approx(U / 1000.0)
    assert loop.force_N == pytest.approx(F)
    assert understood.sentences()
    return understood


HEAD = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t{sign}"]
HEAD += ["Multi_Headings\t{many}", "X_Columns\t{x}", "Time_Pref\tRelative", "Operator\tA", "Date\t2024/05/06", "Time\t10:11:12"]
HEAD += ["***End_of_Header***\t", "\t"]


def segment(first, last, x="One", sign=".", unit="mm"):
    """One segment of two channels; every number with eight digits, as LabVIEW writes them."""
    blank, n = "\t\t\t", last - first
    lines = [f"Channels\t2{blank}", f"Samples\t{n}\t{n}\t", f"Date\t2024/05/06\t2024/05/06{blank}", f"Y_Unit_Label\t{unit}\tN\t"]
    lines += ["X_Dimension\tTime\tTime\t", f"X0\t{T[first]:.8f}\t{T[first]:.8f}\t", "Delta_X\t0.5\t0.5\t", "***End_of_Header***" + blank]
    names = {"One": ["X_Value", "Laser", "Load"], "No": ["X_Value", "Laser", "Load"], "Multi": ["X_Value", "Laser", "X_Value", "Load"]}
    lines += ["\t".join([*names[x], "Comment"])]
    for t, u, f in zip(T[first:last], U[first:last], F[first:last], strict=True):
        cells = {"One": [t, u, f], "No": ["", u, f], "Multi": [t, u, t, f]}[x]
        lines.append("\t".join("" if cell == "" else f"{cell:.8f}" for cell in cells))
    return "\n".join(lines).replace(".", sign) if sign == "," else "\n".join(lines)


def lvm(tmp_path, *segments, x="One", sign=".", encoding="utf-8"):
    head = "\n".join(HEAD).format(sign=sign, x=x, many="Yes" if len(segments) > 1 else "No")
    path = tmp_path / "bench.lvm"
    path.write_bytes((head + "\n" + "\n\t\n".join(segments) + "\n").replace("\n", "\r\n").encode(encoding))
    return path


@pytest.mark.parametrize("x", ["One", "No", "Multi"])
@pytest.mark.parametrize("sign", [".", ","])
def test_a_labview_text_file_gives_its_channels_and_the_time_it_only_implies(tmp_path, x, sign):
    understood = check(lvm(tmp_path, segment(0, 40, x, sign), x=x, sign=sign))
    assert "Date = 2024/05/06" in understood.table.notes


def test_units_of_a_labview_file_need_no_option(tmp_path):
    check(lvm(tmp_path, segment(0, 40)), ColumnMapping({"elongation": "Laser", "force": "Load"}))


def test_segments_that_follow_each_other_are_one_record(tmp_path):
    check(lvm(tmp_path, segment(0, 15), segment(15, 40)))


def test_segments_that_overlap_are_two_tests(tmp_path):
    with pytest.raises(InputError, match="segment 2 begins at 5 s"):
        read_loop_file(lvm(tmp_path, segment(0, 15), segment(10, 40)), NAMED)


def test_no_pickle_beside_a_labview_file_is_opened_or_written(tmp_path):
    path = lvm(tmp_path, segment(0, 40))
    trap = Path(f"{path}.pkl")
    trap.write_bytes(b"cos\nabort\n(tR.")  # a pickle that ends the interpreter
    check(path)
    trap.unlink()
    check(path)
    assert sorted(tmp_path.iterdir()) == [path]


def tdms(tmp_path, channels, **properties):
    path = tmp_path / "bench.tdms"
    with TdmsWriter(path) as writer:
        writer.write_segment([RootObject({"Operator": "A", "frequency": 1.5}), GroupObject("Test", {}), *channels])
    return path


def channel(name, values, group="Test", **properties):
    return ChannelObject(group, name, values, properties)


def test_a_tdms_file_gives_its_channels_units_and_notes(tmp_path):
    path = tdms(tmp_path, [channel("Time", T, unit_string="s"), channel("Laser", U, unit_string="mm"), channel("Load", F, unit_string="N")])
    understood = check(path, ColumnMapping({"elongation": "Laser", "force": "Load"}))
    assert understood.claims == [Claim("a note in it", "frequency", 1.5)]


def test_waveforms_of_a_tdms_file_bring_their_own_time(tmp_path):
    check(tdms(tmp_path, [channel(name, v, wf_increment=0.5, wf_start_offset=0.0) for name, v in (("Laser", U), ("Load", F))]))


def test_instants_of_a_tdms_file_become_seconds_from_the_first(tmp_path):
    instants = np.datetime64("2024-05-06T10:11:12", "us") + (T * 1e6).astype("timedelta64[us]")
    check(tdms(tmp_path, [channel("Time", instants), channel("Laser", U), channel("Load", F)]))


def test_channels_of_several_groups_carry_the_name_of_theirs(tmp_path):
    path = tdms(tmp_path, [channel("Time", T, "A"), channel("Laser", U, "A"), channel("Load", F, "B")])
    columns = {"time": "A/Time", "elongation": "A/Laser", "force": "B/Load"}
    check(path, ColumnMapping(columns, {"time": "s", "elongation": "mm", "force": "N"}))


def matlab73(tmp_path, **variables):
    """What MATLAB writes with "-v7.3": HDF5 behind 512 bytes of its own, columns as rows, a class with every variable."""
    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in variables.items():
            item = file.create_dataset(name, data=np.atleast_2d(values), compression="gzip" if np.size(values) > 1 else None)
            item.attrs["MATLAB_class"] = np.bytes_("char" if item.dtype.kind == "u" else "double")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    return path


def test_a_matlab_file_of_version_73_is_read_by_the_names_of_its_variables(tmp_path):
    path = matlab73(tmp_path, **{"rig/Laser": U, "Load": F, "Ts": 0.5, "f": 1.5, "note": np.arange(40, dtype="u2")})
    mapping = ColumnMapping({"elongation": "rig.Laser", "force": "Load"}, {"elongation": "mm", "force": "N"}, sample_period_s=0.5)
    understood = check(path, mapping)
    assert "note" not in understood.table.header
    assert understood.claims == [Claim("a note in it", "frequency", 1.5)]


def test_units_beside_the_data_sets_of_an_hdf5_file_are_taken(tmp_path):
    path = tmp_path / "bench.h5"
    with h5py.File(path, "w") as file:
        for name, values, unit in (("time", T, "s"), ("elongation", U, "mm"), ("force", F, "N")):
            file.create_dataset(name, data=values).attrs["units"] = unit
    check(path, ColumnMapping())


def test_an_hdf5_file_cannot_have_another_file_read(tmp_path):
    secret = tmp_path / "secret.bin"
    secret.write_bytes(F.tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["force"] = F
    with h5py.File(tmp_path / "bench.h5", "w") as file:
        file["time"], file["elongation"] = T, U
        file["force"] = h5py.ExternalLink("other.h5", "force")
        file.create_dataset("load", (40,), "f8", external=[(str(secret), 0, 320)])
        layout = h5py.VirtualLayout((40,), "f8")
        layout[:] = h5py.VirtualSource("other.h5", "force", (40,))
        file.create_virtual_dataset("virtual", layout)
    with pytest.raises(InputError, match='found "elongation", "time"'):
        read_loop_file(tmp_path / "bench.h5", ColumnMapping(units={"time": "s", "elongation": "mm"}))


def test_a_file_that_promises_more_than_a_loop_holds_is_refused_unread(tmp_path):
    with h5py.File(tmp_path / "bomb.h5", "w") as file:
        file.create_dataset("force", (1_000_000_000,), "f8", compression="gzip", chunks=(1_000_000,))
    with pytest.raises(InputError, match="1000000000 numbers"):
        read_loop_file(tmp_path / "bomb.h5")


@pytest.mark.parametrize(
    ("library", "sentence"), [("while True: pass", "does not come to an end of it"), ("import os; os.abort()", "falls over it")]
)
def test_a_file_on_which_the_library_hangs_or_falls_ends_in_a_sentence(tmp_path, monkeypatch, library, sentence):
    path = matlab73(tmp_path, Laser=U, Load=F)
    monkeypatch.setattr(guarded, "_PROCESSOR_S", 1)
    call = guarded._CALL.replace("from measure.readers.formats.guarded import write_vectors", library)
    monkeypatch.setattr(guarded, "_CALL", call)
    with pytest.raises(InputError, match=rf"new.mat: .* {sentence}.*; it is damaged. Save it"):
        read_loop_file(path, NAMED)


@pytest.mark.parametrize(("module", "extra"), [("h5py", "hdf5"), ("nptdms", "labview"), ("lvm_read", "labview")])
def test_a_missing_extra_is_named_with_what_to_do(tmp_path, monkeypatch, module, extra):
    made = {
        "h5py": lambda: matlab73(tmp_path, Laser=U, Load=F),
        "nptdms": lambda: tdms(tmp_path, [channel("Load", F)]),
        "lvm_read": lambda: lvm(tmp_path, segment(0, 40)),
    }
    path = made[module]()
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(
        InputError, match=rf"{module}, which reads it, is not installed. Install it with pip install \"unspool\[{extra}\]\""
    ):
        read_loop_file(path, NAMED)


def test_what_a_package_quotes_of_a_file_is_shown_by_its_beginning(tmp_path):
    path = lvm(tmp_path, segment(0, 40))
    path.write_text(path.read_text().replace("Channels\t2", "Channels\t" + "1" * 100_000 + "x"))
    with pytest.raises(InputError, match="cannot be read as a LabVIEW") as refusal:
        read_loop_file(path, NAMED)
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize("kind", ["lvm", "tdms", "hdf5"])
def test_a_cut_file_is_refused_in_a_sentence(tmp_path, kind):
    made = {
        "lvm": lambda: lvm(tmp_path, segment(0, 40)),
        "tdms": lambda: tdms(tmp_path, [channel("Laser", U), channel("Load", F)]),
        "hdf5": lambda: matlab73(tmp_path, Laser=U, Load=F),
    }
    path = made[kind]()
    path.write_bytes(path.read_bytes()[: {"lvm": 150, "tdms": 90, "hdf5": 700}[kind]])
    with pytest.raises(InputError, match=r"cannot be read as|is cut|holds no|no two"):
        read_loop_file(path, NAMED)


def test_a_tdms_file_that_is_a_few_bytes_short_is_not_read_as_far_as_it_goes(tmp_path, capfd):
    path = tdms(tmp_path, [channel("Time", T), channel("Laser", U), channel("Load", F)])
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(InputError, match="less data than expected"):
        read_loop_file(path, NAMED)
    assert capfd.readouterr().err == ""
