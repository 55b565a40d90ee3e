"""The model file: what is written comes back, and what cannot be is refused in one sentence."""

import string
import tomllib

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from measure.common.errors import InputError
from simulate.effects import CATALOGUE
from simulate.files.model_file import document_of, model_from, read_model, with_changes, write_model
from simulate.model.model import (
    Actuator,
    Covariance,
    EndStop,
    Geometry,
    Gravity,
    Model,
    Nuisance,
    Platform,
    Rate,
    Release,
    Simulation,
    value_of,
    with_value,
)
from simulate.model.possible import impossible_as_changed

TEXT = """
schema = 1
[actuator]
a_l_N_per_m = -0.25
b_l_N = 2.79
a_u_N_per_m = -0.25
b_u_N = 2.89
beta_per_m = 400.0
initial_force_N = 2.987
"""

number = st.floats(-1e3, 1e3).map(float)
positive = st.floats(1e-6, 1.0)
angles = st.tuples(*[st.floats(-6.0, 6.0)] * 3)
inertia = st.tuples(positive, *[st.floats(1.0, 2.0)] * 3).map(lambda drawn: tuple(drawn[0] * share for share in drawn[1:]))
vector = st.tuples(number, number, number)
per_leg = st.one_of(number, st.tuples(*[number] * 6))
words = st.text(string.ascii_letters + string.digits + ' "\\äß.\n', max_size=20)


@st.composite
def effects(draw):
    chosen = draw(st.lists(st.sampled_from(sorted(CATALOGUE)), unique=True, max_size=4))
    made = []
    for name in chosen:
        kind = CATALOGUE[name]
        flat = [draw(st.floats(low, high)) for low, high in kind.bounds().values()]
        made.append(kind().with_flat(np.array(flat)))
    return tuple(made)


def joints(radius_m):
    """Six joints about a circle, each off by up to a fifth of its radius in every direction."""
    turns = [radius_m * np.array([np.cos(a), np.sin(a), 0.0]) for a in np.arange(6) * np.pi / 3]
    off = st.tuples(*[st.floats(-radius_m / 5, radius_m / 5)] * 3)
    return st.tuples(*[off] * 6).map(lambda drawn: tuple(tuple((turn + d).tolist()) for turn, d in zip(turns, drawn, strict=True)))


models = st.builds(
    Model,
    actuator=st.builds(
        Actuator,
        a_l_N_per_m=per_leg,
        b_l_N=per_leg,
        a_u_N_per_m=per_leg,
        b_u_N=per_leg,
        beta_per_m=positive,
        initial_force_N=per_leg,
        rate=st.none() | st.builds(Rate, st.sampled_from(["frequency_Hz", "speed_m_per_s"]), st.lists(number, max_size=3).map(tuple)),
        covariance=st.none() | st.just(Covariance(("b_l_N",), ((0.01,),))),
    ),
    name=words,
    platform=st.builds(Platform, positive, inertia, vector),
    geometry=st.none() | st.builds(Geometry, joints(0.5), joints(0.1), st.just(0.25), st.just(0.65)),
    end_stop=st.builds(EndStop, positive, positive, positive),
    gravity=st.builds(Gravity, number, st.floats(1e-3, 1e3)),
    release=st.builds(Release, vector, angles, vector, vector),
    simulation=st.builds(Simulation, st.floats(1.0, 1e6), st.floats(1e-3, 1e7), st.none() | positive),
    nuisance=st.builds(Nuisance, positive, positive, positive, positive),
    effects=effects(),
)


@settings(max_examples=60, deadline=None)
@given(model=models)
def test_a_written_model_comes_back_the_same(model, tmp_path_factory):
    assume(not impossible_as_changed(model.adjusted()))
    path = tmp_path_factory.mktemp("model") / "model.toml"
    write_model(model, path, {"command": "made up"})
    assert read_model(path) == model


def refused(text):
    with pytest.raises(InputError) as caught:
        model_from(tomllib.loads(text), "bad.toml")
    sentence = str(caught.value)
    assert sentence.startswith("bad.toml")
    assert "\n" not in sentence
    return sentence


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (TEXT.replace("initial_force_N", "intial_force_N"), 'did you mean "initial_force_N"?'),
        (TEXT + "[platfrom]\nmass_kg = 1.0\n", 'did you mean "platform"?'),
        (TEXT + "[platform]\nmas_kg = 1.0\n", 'did you mean "mass_kg"?'),
        (TEXT + "[actuator.rate]\nabscissa = 'speed_m_per_s'\nal = [0.0]\n", 'did you mean "a_l"?'),
        (TEXT + '[[effect]]\nname = "hub-inertai"\n', 'did you mean "hub-inertia"?'),
        (TEXT + '[[effect]]\nname = "hub-inertia"\nmas_kg = 0.1\n', 'did you mean "mass_kg"?'),
        (TEXT + "[effects]\nname = 1\n", 'did you mean "effect"?'),
    ],
)
def test_an_unknown_key_is_refused_with_the_nearest_one(text, named):
    assert named in refused(text)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (TEXT.replace("schema = 1", "schema = 7"), "schema is 7"),
        (TEXT.replace("schema = 1", ""), "schema is absent"),
        (TEXT.replace("beta_per_m = 400.0", "beta_per_m = 0.0"), "beta_per_m"),
        (TEXT.replace("b_u_N = 2.89", ""), "b_u_N"),
        (TEXT.replace("b_u_N = 2.89", 'b_u_N = "much"'), "b_u_N"),
        (TEXT.replace("b_u_N = 2.89", "b_u_N = nan"), "b_u_N"),
        (TEXT.replace("b_u_N = 2.89", "b_u_N = [1.0, 2.0]"), "b_u_N"),
        (TEXT + "[platform]\nmass_kg = -1.0\n", "platform.mass_kg"),
        (TEXT + "[simulation]\nduration_s = inf\n", "simulation.duration_s"),
        (TEXT + '[[effect]]\nname = "hub-inertia"\nmass_kg = -0.1\n', "within 0 and 1e+12"),
        (TEXT + '[[effect]]\nname = "hub-inertia"\nmass_kg = nan\n', "finite"),
        (TEXT + '[[effect]]\nname = "hub-inertia"\n[[effect]]\nname = "hub-inertia"\n', "twice"),
        (TEXT + "[[effect]]\nmass_kg = 0.1\n", "no name"),
        (TEXT + '[effect]\nname = "hub-inertia"\n', "double brackets"),
        ("platform = 3\n" + TEXT, "must be a table"),
    ],
)
def test_a_value_that_cannot_be_is_refused_by_its_key(text, named):
    assert named in refused(text)


@pytest.mark.parametrize("schema", [True, "1", 2, [1]])
def test_another_schema_is_refused(prototype, schema):
    with pytest.raises(InputError, match="this program reads schema = 1"):
        model_from({**document_of(prototype), "schema": schema}, "rig.toml")


def test_a_missing_force_law_is_answered_with_the_lines_to_add():
    with pytest.raises(InputError) as caught:
        model_from({"schema": 1}, "bad.toml")
    head, _, lines = str(caught.value).partition("or add\n")
    assert "no [actuator] table" in head
    assert model_from({"schema": 1, **tomllib.loads(lines)}, "mended.toml").actuator.b_u_N == 2.9


def test_all_that_is_wrong_is_reported_at_once_and_each_only_once():
    text = (
        TEXT.replace("schema = 1", "schema = 2").replace("beta_per_m = 400.0", "beta_per_m = -1.0").replace("b_u_N = 2.89", "b_u_N = [1.0]")
    )
    text += "[platfrom]\nmass_kg = 1.0\n[platform]\nmass_kg = -1.0\n[end_stop]\nstifness_N_per_m = 1.0\n"
    text += '[[effect]]\nname = "hub-inertai"\n[[effect]]\nname = "air-drag"\ncoefficient = 1.0\n'
    text += '[[effect]]\nname = "leg-mass"\nmass_kg = -1.0\n'
    with pytest.raises(InputError) as caught:
        model_from(tomllib.loads(text), "bad.toml")
    said = str(caught.value).splitlines()
    named = ["schema is 2", '"platfrom"', "beta_per_m", "b_u_N", "platform.mass_kg", "stifness", "hub-inertai", '"coefficient"', "leg-mass"]
    assert all(sum(word in line for line in said) == 1 for word in named), said
    assert len(said) == len(named)


def test_a_file_that_is_not_toml_is_refused(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text("schema = = 1")
    with pytest.raises(InputError, match="is not TOML"):
        read_model(path)


def test_what_a_run_changes_is_merged_and_checked_like_a_model_file():
    model = model_from(tomllib.loads(TEXT), "model.toml")
    heavier = with_changes(model, {"platform": {"mass_kg": 1.0}, "actuator": {"b_l_N": 3.0}}, "runs.toml")
    assert heavier.platform.mass_kg == 1.0
    assert heavier.platform.inertia_kg_m2 == model.platform.inertia_kg_m2
    assert (heavier.actuator.b_l_N, heavier.actuator.b_u_N) == (3.0, 2.89)
    with pytest.raises(InputError, match="mass_kg"):
        with_changes(model, {"platform": {"mass_gk": 1.0}}, "runs.toml")


def test_a_value_is_named_as_in_the_file_and_an_index_gives_each_leg_its_own(prototype):
    changed = with_value(prototype, "actuator.b_l_N[2]", 3.0)
    assert changed.actuator.b_l_N == (2.79, 2.79, 3.0, 2.79, 2.79, 2.79)
    assert value_of(changed, "actuator.b_l_N[2]") == 3.0
    assert value_of(prototype, "platform.inertia_kg_m2[2]") == 0.00297
    with pytest.raises(KeyError):
        value_of(prototype, "actuator.b_l_N[6]")
    assert document_of(changed)["actuator"]["b_l_N"][2] == 3.0
