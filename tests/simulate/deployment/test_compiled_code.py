"""Compiled code is shared, and nothing is compiled that a command does not need."""

import subprocess
import sys
from dataclasses import replace

from simulate.kernel.model_rows import formula_table_of
from simulate.kernel.runge_kutta import compiled_stage

ONE_DEPLOYMENT = """
from simulate import deploy, read_model
from simulate.kernel import integrator, response_kernel
deploy(read_model("datasets/prototype.toml"))
loops = (integrator.deploy_block, integrator.deploy_on_all_cores, response_kernel.respond_on_all_cores)
print([len(loop.signatures) for loop in loops])
"""


def test_models_with_the_same_kinds_of_effects_share_their_formulas_and_stages(lopsided):
    heavier = replace(lopsided, platform=replace(lopsided.platform, mass_kg=1.1))
    assert formula_table_of(heavier) is formula_table_of(lopsided)
    assert compiled_stage(1, True, False) is compiled_stage(1, True, False)


def test_a_single_deployment_compiles_neither_the_loop_of_many_nor_that_of_a_sweep(pytestconfig):
    ran = subprocess.run([sys.executable, "-c", ONE_DEPLOYMENT], cwd=pytestconfig.rootpath, capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[1, 0, 0]"
