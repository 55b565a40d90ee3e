"""The same sweep on processes, threads and a cluster: the same bytes, whatever happens to a worker."""

import os
import signal
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.commands import sweep_deployments
from simulate.files.model_file import write_model
from simulate.model.model import Simulation
from simulate.sweeps.chunks import Chunks
from simulate.sweeps.cluster import connected
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import factors_of
from simulate.sweeps.sweep import Sweep, piece_of, run_by, run_on


def sweep_of(model, runs, duration_s=0.2):
    model = replace(model, simulation=Simulation(duration_s, 200.0))
    words = ["actuator.stored_force_N[0]=+-10%", "platform.mass_kg=sigma:1%", "geometry.stowed_height_m=+-1%"]
    factors = tuple(factors_of(model, words))
    return Sweep(model, factors, design_of("random", 3, runs, 4, [1]))


def in_order(computed):
    return np.concatenate([answers for _, answers in sorted(computed, key=lambda piece: piece[0])])


def test_threads_give_the_same_bytes(prototype):
    sweep = sweep_of(prototype, 1100)  # three pieces
    with ThreadPoolExecutor(3) as executor:
        np.testing.assert_array_equal(in_order(run_by(executor, sweep)), in_order(run_on(sweep)))


def test_a_sweep_that_has_computed_something_is_sent_as_plain_data(prototype):
    import pickle

    sweep = sweep_of(prototype, 20)
    answers = sweep.responses(0, 20)
    sent = pickle.loads(pickle.dumps(sweep))
    assert set(vars(sent)) == {"model", "factors", "design", "longest_s"}
    np.testing.assert_array_equal(piece_of(sent, 0, 20)[1], answers)


@pytest.mark.calibrate
def test_processes_give_the_same_bytes_and_a_killed_one_loses_nothing_that_came_back(prototype, tmp_path):
    sweep = sweep_of(prototype, 8192, duration_s=1.0)
    kept = Chunks(tmp_path / "sweep.part", sweep)
    kept.open(resume=False)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        pids = {executor.submit(os.getpid).result() for _ in range(4)}
        computed = kept.keep(run_by(executor, sweep))
        next(computed)
        os.kill(min(pids), signal.SIGKILL)
        with pytest.raises(InputError, match="go on with --resume"):
            list(computed)
    left = len(kept.missing)
    assert 0 < left < 16
    kept.open(resume=True)
    assert len(kept.missing) == left
    list(kept.keep(run_on(sweep, only=kept.missing)))
    np.testing.assert_array_equal(np.concatenate(list(kept)), in_order(run_on(sweep)))


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed", reason='dask is not installed: pip install "unspool[dask]"')
    settings = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None, "silence_logs": 50}
    with distributed.LocalCluster(**settings) as made:
        yield made


@pytest.mark.calibrate
def test_a_worker_killed_in_mid_sweep_loses_nothing_and_changes_no_byte(cluster, prototype, tmp_path, monkeypatch):
    write_model(prototype, tmp_path / "prototype.toml")
    words = [str(tmp_path / "prototype.toml"), "--design", "random", "--runs", "8192", "--set", "simulation.duration_s=0.3", "--quiet"]
    assert sweep_deployments.main([*words, "-o", str(tmp_path / "here")]) == 0
    pids, kept, killed = [worker.process.pid for worker in cluster.workers.values()], Chunks.keep, []

    def killing(chunks, computed):
        for number, first in enumerate(kept(chunks, computed), 1):
            if number == 3:
                os.kill(pids[0], signal.SIGKILL)
                killed.append(len(chunks.missing))
            yield first

    monkeypatch.setattr(Chunks, "keep", killing)
    assert sweep_deployments.main([*words, "-o", str(tmp_path / "there"), "--dask", cluster.scheduler_address]) == 0
    assert killed == [13]
    assert pids[0] not in [worker.process.pid for worker in cluster.workers.values()]
    for name in ("responses.csv", "coefficients.csv", "sweep.png"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


@pytest.mark.calibrate
def test_a_worker_of_another_version_is_refused(cluster, monkeypatch):
    monkeypatch.setattr("simulate.sweeps.cluster.metadata.version", lambda name: "0.0.1")
    with pytest.raises(InputError, match="Install the same"), connected(cluster.scheduler_address):
        pass


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "no address at all"])
def test_a_cluster_that_is_not_there_is_said_to_be_absent_and_nothing_is_written(prototype, tmp_path, monkeypatch, capsys, address):
    pytest.importorskip("distributed", reason='dask is not installed: pip install "unspool[dask]"')
    monkeypatch.setattr("simulate.sweeps.cluster._PATIENCE_S", 1)
    write_model(prototype, tmp_path / "prototype.toml")
    words = ["--design", "random", "--runs", "20", "--dask", address, "-o", str(tmp_path / "out")]
    assert sweep_deployments.main([str(tmp_path / "prototype.toml"), *words]) == 2
    assert "no scheduler answers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert not (tmp_path / "out.part").exists()
