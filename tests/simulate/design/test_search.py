"""The search finds what is known: on responses that are a formula, in milliseconds, and once on the rig itself."""

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.design.measures import Limit, Measure
from simulate.design.problem import Free, Problem, factor_costs
from simulate.design.search import Found, _Tried, design_deployment
from simulate.model import responses
from simulate.model.model import value_of
from simulate.sweeps.factors import factors_of

SLOPES_DEG_PER_N = np.array([365.0, -365.0, 365.0, -365.0, 365.0, -365.0])
LEGS = [f"actuator.stored_force_N[{leg}]" for leg in range(6)]


def answers_of(theta_deg, stop_force=0.0):
    answers = np.zeros((len(theta_deg), responses.COUNT))
    answers[:, responses.THETA_Z], answers[:, responses.STOP_FORCE] = np.radians(theta_deg), stop_force
    answers[:, responses.DIVERGED] = np.nan
    return answers


def turned_by_forces(slopes=SLOPES_DEG_PER_N):
    def respond(sweep, coded):
        shifts = coded * [(factor.high - factor.low) / 2 for factor in sweep.factors]
        return answers_of(shifts @ slopes)

    return respond


def budget(prototype, slopes=SLOPES_DEG_PER_N, costs=None):
    return Problem(
        prototype,
        tuple(Free(f"tolerance.{key}", 1e-4, 0.1) for key in LEGS),
        Measure.of("cost"),
        (Limit.of("p95:theta_z_deg<5"),),
        tuple(factors_of(prototype, [f"{key}=sigma:0.01" for key in LEGS])),
        costs or {},
        draws=512,
        respond=turned_by_forces(slopes),
    )


def test_the_papers_inverse_regression_is_one_case_the_tolerance_that_keeps_an_angle(prototype):
    found = design_deployment(budget(prototype), 1200)
    # s = angle / (z |g|), all legs alike
    alike = 5.0 / (1.959964 * np.linalg.norm(SLOPES_DEG_PER_N))
    cost = 6 * 0.01 / alike
    assert found.searched[0] == pytest.approx(cost, rel=0.06)
    assert np.median(found.values) == pytest.approx(alike, rel=0.1)


def test_a_leg_that_turns_the_platform_more_gets_the_finer_tolerance(prototype):
    slopes = SLOPES_DEG_PER_N * [4.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    found = design_deployment(budget(prototype, slopes), 1500)
    # least sum of c / t with sum (g t)^2 fixed: t goes as g^(-2/3)
    assert found.values[0] / np.mean(found.values[1:]) == pytest.approx(4.0 ** (-2.0 / 3.0), rel=0.2)


def test_the_least_of_a_bowl_within_a_limit_lies_on_the_limit(prototype):
    def respond(sweep, coded):
        damping, mass = value_of(sweep.model, "end_stop.damping_N_s_per_m"), value_of(sweep.model, "platform.mass_kg")
        turned = 10.0 + (damping - 30.0) ** 2 / 10.0 + (mass - 0.9) ** 2 * 100.0
        return answers_of(np.full(len(coded), turned), stop_force=2.0 * damping)

    free = (Free.of("end_stop.damping_N_s_per_m=5..80"), Free.of("platform.mass_kg=0.5..1.5"))
    goal, limit = Measure.of("nominal:theta_z_deg"), Limit.of("worst:stop_force_N<40")
    unbound = design_deployment(Problem(prototype, free, goal, respond=respond), 300)
    assert unbound.verdict == "found"
    assert unbound.values == pytest.approx([30.0, 0.9], rel=0.02)
    bound = design_deployment(Problem(prototype, free, goal, (limit,), respond=respond), 300)
    assert bound.values == pytest.approx([20.0, 0.9], rel=0.03)
    assert bound.report["limits"][0]["kept"]
    assert value_of(bound.model, "platform.mass_kg") == bound.values[1]


def test_where_no_candidate_keeps_the_limit_it_is_said(prototype):
    problem = Problem(
        prototype,
        (Free.of("platform.mass_kg=0.5..1.5"),),
        Measure.of("nominal:theta_z_deg"),
        (Limit.of("nominal:theta_z_deg<1"),),
        respond=lambda sweep, coded: answers_of(np.full(len(coded), 7.0)),
    )
    found = design_deployment(problem, 40)
    assert found.verdict == "none-feasible"


def test_candidates_that_no_model_can_be_are_passed_over(prototype):
    # a platform that is deployed below where it is stowed
    def respond(sweep, coded):
        return answers_of(np.full(len(coded), 100.0 * sweep.model.geometry.deployed_height_m))

    free, measure = Free.of("geometry.deployed_height_m=0.1..0.9"), Measure.of("nominal:theta_z_deg")
    problem = Problem(prototype, (free,), measure, respond=respond)
    found = design_deployment(problem, 60)
    assert 0.25 < found.values[0] < 0.3


def test_a_factor_follows_the_candidates_own_value(prototype):
    problem = Problem(
        prototype,
        (Free.of("platform.mass_kg=0.5..1.5"),),
        Measure.of("worst:theta_z_deg"),
        factors=tuple(factors_of(prototype, ["platform.mass_kg=+-0.1"])),
    )
    sweep = problem.candidate(np.array([1.2]))
    assert sweep is not None
    assert (sweep.factors[0].low, sweep.factors[0].high) == pytest.approx((1.1, 1.3))


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"free": ()}, "nothing is free"),
        ({"free": (Free("platform.mas_kg", 0.5, 1.0),)}, "no number of the model"),
        ({"free": (Free("tolerance.platform.mass_kg", 0.1, 1.0),)}, "nothing varies by that name"),
        ({"free": (Free("platform.mass_kg", 0.5, 1.0),) * 2}, "given twice"),
        ({"objective": Measure.of("robust:theta_z_deg")}, "give --factor"),
        ({"objective": Measure.of("cost")}, "give --free tolerance"),
        ({"costs": {"platform.mass_kg": 2.0}}, "its tolerance is not free"),
        ({"free": (Free("geometry.deployed_height_m", 0.05, 0.2),)}, "a model that can be"),
    ],
)
def test_a_problem_that_cannot_be_posed_is_refused_in_a_sentence(prototype, changes, named):
    problem = Problem(prototype, (Free("platform.mass_kg", 0.5, 1.0),), Measure.of("nominal:theta_z_deg"))
    with pytest.raises(InputError, match=named):
        replace(problem, **changes).require_usable()


@pytest.mark.parametrize("text", ["platform.mass_kg", "platform.mass_kg=1..0.5", "platform.mass_kg=a..b", "tolerance.x=0..1"])
def test_bounds_that_are_none_are_refused(text):
    with pytest.raises(InputError):
        Free.of(text)


def test_costs_are_numbers_above_zero():
    assert factor_costs(["actuator.stored_force_N[0]=2"]) == {"actuator.stored_force_N[0]": 2.0}
    with pytest.raises(InputError, match="above zero"):
        factor_costs(["a=-1"])


def test_candidates_are_tried_in_the_middle_on_draws_and_at_all_corners_of_what_has_two_ends(prototype):
    factors = factors_of(prototype, [f"{LEGS[0]}=+-0.02", f"{LEGS[1]}=sigma:0.01", f"{LEGS[2]}=2.6..3.0"])
    problem = replace(budget(prototype), factors=tuple(factors), free=(Free(f"tolerance.{LEGS[1]}", 1e-4, 0.1),), draws=8)
    levels = problem.scenarios.levels
    assert problem.scenarios.draws == 8
    assert levels.shape == (1 + 8 + 4, 3)
    assert levels[0].tolist() == [0.0, 0.0, 0.0]
    assert np.abs(levels[1:9, [0, 2]]).max() <= 1.0
    assert sorted(levels[9:].tolist()) == [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0]]
    assert np.array_equal(problem.drawn(8, 3).levels[9:], levels[9:])
    assert not np.array_equal(problem.drawn(8, 3).levels[1:9], levels[1:9])
    without = replace(problem, factors=())
    assert without.scenarios.levels.shape == (1, 0)


def test_a_tolerance_costs_in_inverse_proportion_to_its_size(prototype):
    costly = budget(prototype, costs={LEGS[0]: 5.0})
    as_given = costly.cost(np.full(6, 0.01))
    assert as_given == pytest.approx(5.0 + 5 * 1.0)
    assert costly.cost(np.array([0.005, 0.01, 0.01, 0.01, 0.01, 0.02])) == pytest.approx(10.0 + 4 * 1.0 + 0.5)
    assert costly.given == pytest.approx(np.full(6, 0.01))


MASS, DAMPING = Free("platform.mass_kg", 0.5, 1.5), Free("end_stop.damping_N_s_per_m", 10.0, 90.0)


def test_values_are_even_over_their_bounds_and_tolerances_over_their_decades(prototype):
    tried = _Tried(replace(budget(prototype), free=(MASS, Free(f"tolerance.{LEGS[0]}", 1e-4, 1e-2))), None)
    for place, values in (((0.0, 0.0), (0.5, 1e-4)), ((0.25, 0.5), (0.75, 1e-3)), ((1.0, 1.0), (1.5, 1e-2))):
        assert tried.values_of(np.array(place)) == pytest.approx(values)
        assert tried.place_of(np.array(values)) == pytest.approx(place)
    assert tried.values_of(np.array([-0.3, 1.7])) == pytest.approx([0.5, 1e-2])
    assert tried.place_of(np.array([9.0, 1e-9])) == pytest.approx([1.0, 0.0])


def tried_on(prototype, limit=None):
    """What turns is a bowl about the middle of both bounds; the stops are pressed in proportion to the damping."""

    def respond(sweep, coded):
        damping, mass = value_of(sweep.model, DAMPING.key), value_of(sweep.model, MASS.key)
        return answers_of(np.full(len(coded), 10.0 * (mass - 1.0) ** 2 + (damping - 50.0) ** 2 / 100.0), stop_force=damping)

    limits = () if limit is None else (Limit.of(f"worst:stop_force_N<{limit}"),)
    counted: list[int] = []
    problem = Problem(prototype, (MASS, DAMPING), Measure.of("nominal:theta_z_deg"), limits, respond=respond)
    return _Tried(problem, counted.append), counted


def test_the_best_place_keeps_the_limits_before_it_turns_less_and_where_none_does_breaks_them_least(prototype):
    places = [np.array(place) for place in ((0.5, 0.5), (0.5, 0.25), (0.0, 0.25), (0.5, 0.125))]
    for limit, expected in ((None, 0), (30.0, 1), (25.0, 3), (12.0, 3), (90.0, 0)):
        assert np.array_equal(tried_on(prototype, limit)[0].best(places), places[expected]), limit
    tried, counted = tried_on(prototype, 30.0)
    assert tried.excess(places[0]) == pytest.approx([20.0 / 30.0])
    assert tried.excess(places[3]) == pytest.approx([-10.0 / 30.0])
    for damping in (0.5, -3.0, 0.0):
        tried.at(np.array([0.5, damping]))
    assert counted == [1, 2, 3], "a place that was tried is not tried again"


def found_of(prototype, values=(1.0, 50.0), searched=(1.0, 20.0), fresh=(1.5, 25.0), **changed):
    problem = replace(tried_on(prototype, 30.0)[0].problem, **changed)
    return Found(problem, np.array(values), np.array([9.0, 40.0]), np.array(searched), np.array(fresh), 200, 17)


@pytest.mark.parametrize(
    ("searched", "fresh", "verdict"),
    [((1.0, 20.0), (1.5, 25.0), "found"), ((1.0, 20.0), (1.5, 31.0), "not-kept"), ((1.0, 31.0), (1.5, 25.0), "none-feasible")],
)
def test_a_verdict_asks_for_the_limits_where_it_searched_and_on_fresh_draws(prototype, searched, fresh, verdict):
    found = found_of(prototype, searched=searched, fresh=fresh)
    assert found.verdict == found.report["verdict"] == verdict
    assert found.report["limits"][0] == {
        "measure": "worst:stop_force_N", "below": 30.0, "before": 40.0, "searched": searched[1], "fresh": fresh[1],
        "kept": fresh[1] <= 30.0,
    }  # fmt: skip


@pytest.mark.parametrize(("mass", "side"), [(0.5, "low"), (0.5009, "low"), (0.5011, None), (1.4989, None), (1.4991, "high"), (1.5, "high")])
def test_a_value_within_a_thousandth_of_its_range_is_at_its_bound(prototype, mass, side):
    assert [free["at_bound"] for free in found_of(prototype, values=(mass, 50.0)).report["free"]] == [side, None]


def test_a_share_of_failures_has_the_interval_of_its_fresh_draws(prototype):
    report = found_of(prototype, objective=Measure.of("failed_percent"), fresh=(10.0, 25.0)).report
    goal = report["objective"]
    # Wilson 1927 by hand: 20 of 200
    z, n, p = 1.959964, 200, 0.1
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    assert goal["interval_percent"] == pytest.approx([100 * (middle - half) / (1 + z * z / n), 100 * (middle + half) / (1 + z * z / n)])
    assert (goal["before"], goal["searched"], goal["fresh"]) == (9.0, 1.0, 10.0)
    assert "interval_percent" not in found_of(prototype).report["objective"]
    assert (report["draws"], report["fresh_draws"], report["evaluations"]) == (0, 200, 17)


def test_a_tolerance_spreads_about_the_middle_of_its_factor_and_what_cannot_be_is_very_bad(prototype):
    problem = replace(budget(prototype), free=(Free(f"tolerance.{LEGS[2]}", 1e-4, 0.1),))
    sweep = problem.candidate(np.array([0.03]))
    assert sweep is not None
    assert [(f.low, f.high) for f in sweep.factors[1:3]] == [pytest.approx((2.78, 2.80)), pytest.approx((2.76, 2.82))]
    heights = Problem(prototype, (Free("geometry.deployed_height_m", 0.1, 0.9),), Measure.of("nominal:theta_z_deg"))
    assert heights.candidate(np.array([0.2])) is None
    assert heights.measured(np.array([0.2])).tolist() == [1e12]
    never = replace(heights, respond=lambda sweep, coded: answers_of(np.full(len(coded), np.nan)))
    assert never.measured(np.array([0.6])).tolist() == [1e12]


def test_bounds_in_which_only_one_end_can_be_are_searched(prototype):
    problem = Problem(prototype, (Free("geometry.deployed_height_m", 0.05, 0.3),), Measure.of("nominal:theta_z_deg"))
    problem.require_usable()
    replace(problem, free=(Free("platform.mass_kg", 0.5, 9e6),)).require_usable()
