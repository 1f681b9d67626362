"""Branches of periodic orbits in Python: against closed forms, and what a user does with them."""

import pickle
import signal

import numpy as np
import pytest

import vibroimpact as vi

SYSTEM = vi.LinearSystem(1.0, 0.1, 1.0)


def scene(force=8.5, frequency=2.4, clearance=1.0, restitution=0.8):
    return vi.Scene(SYSTEM, vi.Harmonic([force], frequency), vi.Stop(0, clearance, restitution))


def orbit(**numbers):
    return vi.periodic_orbits(scene(**numbers), [0])[0]


def miss(speed, force=8.5, frequency=2.4, clearance=1.0, restitution=0.8):
    """By how much a speed misses the closed form of one impact in one period (theory 19), in parts of the amplitude."""
    eta, w, e = 0.05, frequency, restitution
    period, own = 2 * np.pi / w, np.sqrt(1 - eta**2)
    decay = np.exp(-eta * period)
    cos, sin, end = decay * np.cos(own * period), decay * np.sin(own * period) / own, decay**2
    every = 1 - 2 * cos + end
    a, b = (1 + e) * sin / every, 1 + (1 + e) * (cos - eta * sin - end) / every
    x = force / np.hypot(1 - w**2, 2 * eta * w)
    return np.hypot(clearance + a * speed, b * speed / w) / x - 1


class TestCurve:
    @pytest.mark.parametrize(
        ("name", "between"), [("frequency", (2.0, 2.9)), ("clearance", (0.2, 1.5)), ("restitution", (0.6, 0.95))]
    )
    def test_lies_on_the_closed_form(self, name, between):
        branch = vi.continuation(orbit(), name, between)
        assert len(branch) > 5
        speeds = branch.speeds_before[:, 0]
        assert max(abs(miss(u, **{name: p})) for u, p in zip(speeds, branch.parameter, strict=True)) < 1e-9
        assert (np.diff(branch.arclength) > 0).all()
        assert 0.0 in branch.arclength

    def test_a_callable_gives_what_the_name_gives(self):
        by_name = vi.continuation(orbit(), "forcing_scale", (0.7, 1.5), direction="up")
        made = vi.continuation(orbit(), lambda force: scene(force=force), (0.7 * 8.5, 1.5 * 8.5), start=8.5, direction="up")
        assert made.parameter_name is None
        assert made.ends[0][0] == by_name.ends[0][0] == "start"
        np.testing.assert_allclose(made.parameter, 8.5 * by_name.parameter, rtol=1e-6)
        for u, force in zip(made.speeds_before[:, 0], made.parameter, strict=True):
            assert abs(miss(u, force=force)) < 1e-9

    def test_multipliers_count_what_grows(self):
        branch = vi.continuation(orbit(force=9.0), "forcing_scale", (0.6, 1.2))
        assert not branch.is_virtual.any()
        outside = (np.abs(branch.multipliers) > 1.0).sum(axis=1)
        np.testing.assert_array_equal(branch.n_unstable, outside)
        np.testing.assert_array_equal(branch.is_stable, branch.n_unstable == 0)
        # Period doubling at F = 7.73325782164.
        force = 9.0 * branch.parameter
        assert branch.is_stable[force > 7.7333].all()
        assert not branch.is_stable[force < 7.7332].any()

    def test_orbits_at_a_value(self):
        # Two orbits above the fold at 0.39322555956.
        branch = vi.continuation(orbit(force=1.0, frequency=2.8, clearance=-0.5), "forcing_scale", (0.2, 2.0), virtual="keep")
        found = branch.at(0.45)
        assert len(found) == 2
        speeds = sorted(own.impacts["speed_before"][0] for own in found)
        assert speeds[0] + 0.1 < speeds[1]
        for u in speeds:
            assert abs(miss(u, force=0.45, frequency=2.8, clearance=-0.5)) < 1e-9
        assert branch.at(0.39) == []
        # Both sides of the fold end at the end of the range.
        assert branch.at(2.0) == [branch[0], branch[-1]]
        with pytest.raises(ValueError, match="value is nan"):
            branch.at(np.nan)

    def test_orbits_at_values_beside_a_fold_between_two_points(self):
        # Long steps: between the points on both sides of the fold all orbits beside it.
        scene = {"frequency": 2.8, "clearance": -0.5}
        branch = vi.continuation(orbit(force=1.0, **scene), "forcing_scale", (0.2, 2.0), virtual="keep", step=(1e-3, 0.5, 0.5))
        (fold,) = (own for own in branch.special if own.kind == "fold")
        there = np.flatnonzero(branch.arclength < fold.arclength)[-1]
        values = branch.parameter[there : there + 2]
        for value in fold.parameter + np.array([1e-6, 1e-4, 1e-3, 0.3 * np.ptp(values), 0.8 * np.ptp(values), 0.1]):
            found = branch.at(value)
            assert len(found) == 2
            speeds = [own.impacts["speed_before"][0] for own in found]
            assert max(abs(miss(u, force=value, **scene)) for u in speeds) < 1e-9
            assert abs(speeds[0] - speeds[1]) > 0.1 * np.sqrt(value - fold.parameter)
        assert branch.at(fold.parameter) == [fold.orbit]

    def test_special_points(self):
        branch = vi.continuation(orbit(force=1.0, frequency=2.8, clearance=-0.5), "forcing_scale", (0.2, 9.0))
        found = {own.kind: own for own in branch.special}
        assert found["fold"].parameter == pytest.approx(0.3932255639773, abs=1e-12)
        assert found["period_doubling"].parameter == pytest.approx(7.7482374608, abs=1e-9)
        assert max(own.error for own in branch.special) < 1e-9
        assert min(abs(found["period_doubling"].orbit.floquet_multipliers + 1)) < 1e-8
        assert min(abs(found["fold"].orbit.floquet_multipliers - 1)) < 1e-4  # as the square root of the error
        lengths = [own.arclength for own in branch.special]
        assert lengths == sorted(lengths)
        assert not found["fold"].is_virtual
        assert found["fold"].stop is None
        assert "Special(fold at 0.3932255" in repr(branch)

    def test_what_ends_it_is_named(self):
        branch = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5))
        lost = branch.special[0]
        assert (lost.kind, lost.stop, lost.parameter) == ("lost_impact", 0, branch.parameter[0])
        assert 8.5 * lost.parameter == pytest.approx(4.76604658, rel=1e-9)

    def test_a_motion_that_hits_nothing_is_followed_to_its_touch(self):
        rest = vi.periodic_orbits(scene(force=1.0), [])[0]
        branch = vi.continuation(rest, "forcing_scale", (0.5, 9.0))
        assert branch.ends[1][0] == "boundary"
        assert branch.parameter[-1] == pytest.approx(4.76604658, rel=1e-8)
        assert branch.speeds_before.shape == (len(branch), 0)


@pytest.fixture(scope="module")
def branch():
    return vi.continuation(orbit(), "frequency", (2.2, 2.6), monitor={"period": lambda own: own.period})


class TestNearby:
    def test_orbits_beside_a_point(self):
        branch = vi.continuation(orbit(), "frequency", (2.3, 2.5))
        for part in (-1e-10, -1e-12, 2e-16, 1e-14, 1e-11, 1e-9):
            for value in branch.parameter[1:-1:7] * (1 + part):
                (found,) = branch.at(value)
                assert abs(miss(found.impacts["speed_before"][0], frequency=value)) < 1e-9

    def test_ranges_of_next_to_nothing(self):
        for width in (1e-12, 1e-9, 5e-16):
            short = vi.continuation(orbit(), "frequency", (2.4 - width, 2.4 + width))
            assert [reason for reason, _ in short.ends] == ["range", "range"]

    def test_impacts_that_take_all_speed_beside_the_origin(self):
        # Behind each impact the state is all but zero.
        system = vi.LinearSystem(1.0, 0.1, 1.0, load=[-1.0])
        for clearance in (0.0, 1e-9):
            made = vi.Scene(system, vi.Harmonic([3.0], 1.5586206896551724), vi.Stop(0, clearance, 0.0))
            found = next(own for own in vi.periodic_orbits(made, [0]) if own.is_admissible)
            branch = vi.continuation(found, "forcing_scale", (0.9, 1.1))
            assert len(branch) > 5
            assert branch.is_admissible[1:-1].all()

    def test_a_boundary_does_not_depend_on_the_steps(self):
        # At a subharmonic resonance without damping an impact loses its speed.
        made = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([0.5], 0.7), vi.Stop(0, 1.0, 0.5))
        found = next(own for own in vi.periodic_orbits(made, [0], 2) if own.is_admissible)
        for largest in (0.05, 0.01):
            branch = vi.continuation(found, "frequency", (0.5, 0.72), step=(1e-8, 1e-3, largest), direction="down")
            assert branch.ends[0][0] in ("boundary", "step")
            assert branch.parameter[0] == pytest.approx(2 / 3, abs=1e-7)

    def test_a_stop_at_the_origin(self):
        system = vi.LinearSystem(2.663315217698477, 0.2685788340786355, 16.739192399250783, load=[1.4791525333751003])
        made = vi.Scene(system, vi.Harmonic([-0.2985169728691671], 2.8474469723215172), vi.Stop(0, 0.0, 1.0, side="lower"))
        found = next(own for own in vi.periodic_orbits(made, [0]) if own.is_admissible)
        ends = [vi.continuation(found, "frequency", (1.7, 4.5), step=(1e-8, 1e-3, s)).parameter[[0, -1]] for s in (0.05, 0.02)]
        np.testing.assert_allclose(ends[0], ends[1], rtol=1e-7)
        np.testing.assert_allclose(ends[0], [2.24432995, 2.74280988], rtol=1e-7)

    def test_a_motion_that_feeds_itself_is_stable_but_for_a_shift_in_time(self):
        made = vi.Scene(vi.LinearSystem(1.0, -0.1, 1.0), None, vi.Stop(0, 0.3, 0.6))
        found = vi.find_orbit(made, vi.simulate(made, 0.0, 0.5, (0, 200)))
        branch = vi.continuation(found, "clearance", (0.1, 0.5))
        assert branch.is_stable.all()
        assert not branch.n_unstable.any()


class TestResult:
    def test_is_a_sequence_of_orbits(self, branch):
        assert branch[0] is branch.orbits[0]
        assert branch[-2:] == branch.orbits[-2:]
        assert list(branch) == list(branch.orbits)
        assert branch.pattern == [0]
        assert branch.n_periods == 1
        assert branch.parameter_name == "frequency"
        np.testing.assert_allclose(branch.monitor["period"], 2 * np.pi / branch.parameter, rtol=1e-14)
        assert "frequency from 2.2 to 2.6" in repr(branch)
        assert repr(branch).count("\n  range:") == 2

    def test_goes_out_and_comes_back(self, branch, tmp_path):
        branch.save(tmp_path / "branch.npz")
        for again in (pickle.loads(pickle.dumps(branch)), vi.load(tmp_path / "branch.npz")):
            assert again.ends == branch.ends
            for name, values in branch.to_arrays().items():
                np.testing.assert_array_equal(again.to_arrays()[name], values)
            assert len(again.at(2.31)) == 1

    def test_a_callable_is_not_saved(self):
        made = vi.continuation(orbit(), lambda w: scene(frequency=w), (2.3, 2.5), start=2.4)
        value = float(np.mean(made.parameter[:2]))
        assert len(made.at(value)) == 1
        again = pickle.loads(pickle.dumps(made))
        assert len(again.at(float(made.parameter[1]))) == 1
        with pytest.raises(ValueError, match="the callable that made the branch was not saved"):
            again.at(value)

    def test_refuses_what_is_no_branch(self, branch):
        own = list(branch.__reduce__()[1])
        for place, wrong, error in [
            (1, (), TypeError),
            (2, branch.parameter[:-1], ValueError),
            (6, branch.n_unstable.astype(float), ValueError),
            (8, (1,), TypeError),
            (9, {"period": branch.parameter[:2]}, ValueError),
            (10, (("range", ""), ("tired", "")), ValueError),
        ]:
            with pytest.raises(error):
                vi.Branch(*own[:place], wrong, *own[place + 1 :])
        with pytest.raises(ValueError, match="kind is 'bend'"):
            vi.Special("bend", 1.0, 0.0, 0.0, branch[0], None, None, {}, np.zeros(4), None, (0.0, 2.0))
        with pytest.raises(TypeError, match="stop is 'a'"):
            vi.Special("fold", 1.0, 0.0, 0.0, branch[0], "a", None, {}, np.zeros(4), None, (0.0, 2.0))


class TestBadInput:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (
                ("freq", (2, 3)),
                r'parameter is "freq" .it is called frequency here., but .* Scene.replace .* or a callable p -> Scene',
            ),
            (("phase", (0, 1)), 'parameter is "phase"'),
            (("clearance[4]", (0, 1)), r'parameter is "clearance\[4\]"'),
            (("frequency", (2.5, 3)), r"between is \(2.5, 3\), but the orbit is at 2.4: it must lie inside"),
            (("frequency", (3, 2)), "the first must be the lower one"),
            (("frequency", (2.4, np.inf)), "between"),
            (("restitution", (0.5, 1.5)), "between"),
            (("frequency", (1, 2, 3)), r"between is \(1, 2, 3\), but \(low, high\) is needed"),
            ((lambda p: scene(), (0, 1)), "start is None, but with a callable it must be the value of p at the orbit"),
        ],
    )
    def test_what_is_followed(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            vi.continuation(orbit(), *arguments)

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"step": (0.0, 1e-3, 0.1)}, "step is"),
            ({"step": (1e-8, 0.2, 0.1)}, "step is"),
            ({"step": (1e-8, np.nan, 0.1)}, "step"),
            ({"max_points": 0}, "max_points is 0"),
            ({"direction": "left"}, 'direction is "left"'),
            ({"virtual": "drop"}, "virtual is 'drop'"),
            ({"monitor": {"bad": lambda own: np.nan}}, r"monitor\['bad'\] at point 0 is NaN"),
            ({"step": (1e-8, 0.1)}, r"step is \(1e-08, 0.1\), but \(smallest, first, largest\) is needed"),
            ({"start": 2.35}, "start is 2.35, but it is that of a callable"),
        ],
    )
    def test_how(self, options, message):
        with pytest.raises(ValueError, match=message):
            vi.continuation(orbit(), "frequency", (2.3, 2.5), **options)

    def test_types(self):
        with pytest.raises(TypeError, match="orbit is 1, but an Orbit is needed"):
            vi.continuation(1, "frequency", (2, 3))
        with pytest.raises(TypeError, match="parameter is 3"):
            vi.continuation(orbit(), 3, (2, 3))
        for wrong in ({"a": 3}, [len], {3: len}):
            with pytest.raises(TypeError, match=r"monitor is .*, but names with functions"):
                vi.continuation(orbit(), "frequency", (2, 3), monitor=wrong)
        for wrong in ("a", None, [2.4]):
            with pytest.raises((TypeError, ValueError), match="value"):
                vi.continuation(orbit(), "frequency", (2.3, 2.5), direction="up").at(wrong)
        with pytest.raises(TypeError, match=r"parameter\(2.4.*\) is None, but a Scene is needed"):
            vi.continuation(orbit(), lambda w: None, (2, 3), start=2.4)

    def test_what_forms_a_family_or_hits_together(self):
        free = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, vi.Stop(0, 1.0, 1.0))
        run = vi.simulate(free, 0.0, 2.0, (0, 30))
        with pytest.raises(ValueError, match="one of a family"):
            vi.continuation(vi.find_orbit(free, run), "clearance", (0.5, 1.5))
        # Two masses alike, side by side.
        pair = vi.Scene(
            vi.LinearSystem([1.0, 1.0], [0.1, 0.1], [1.0, 1.0]),
            vi.Harmonic([8.5, 8.5], 2.4),
            [vi.Stop(k, 1.0, 0.8) for k in (0, 1)],
        )
        together = vi.find_orbit(pair, vi.simulate(pair, [0.0, 0.0], [0.0, 0.0], (0, 150 * pair.period)))
        assert together.pattern == [(0, 1)]
        with pytest.raises(ValueError, match="several stops at one instant"):
            vi.continuation(together, "frequency", (2.3, 2.5))

    def test_a_start_that_is_another_value(self):
        with pytest.raises(ValueError, match=r"start is 2\.45, but the scene of 2\.45 is not that of the orbit"):
            vi.continuation(orbit(), lambda w: scene(frequency=w), (2, 3), start=2.45)

    def test_another_scene(self):
        other = vi.Scene(
            vi.LinearSystem(np.eye(2), 0.1 * np.eye(2), np.eye(2)), vi.Harmonic([1.0, 0.0], 2.4), vi.Stop(0, 1.0, 0.8)
        )
        with pytest.raises(ValueError, match=r"coordinates|degrees of freedom"):
            vi.continuation(orbit(), lambda w: other, (2, 3), start=2.4)


class TestBrokenOff:
    def test_a_function_that_raises_leaves_the_branch(self):
        def made(w):
            if w > 2.5:
                raise RuntimeError("no such machine")
            return scene(frequency=w)

        with pytest.raises(RuntimeError, match="no such machine") as caught:
            vi.continuation(orbit(), made, (2.3, 2.8), start=2.4, direction="up")
        branch = caught.value.branch
        assert branch.ends[1][0] == "interrupted"
        assert 2.4 < branch.parameter[-1] <= 2.5
        assert any("the branch is kept" in note for note in caught.value.__notes__)

    def test_a_value_that_is_refused_ends_it(self):
        def made(w):
            if w > 2.5:
                raise ValueError("too fast")
            return scene(frequency=w)

        branch = vi.continuation(orbit(), made, (2.3, 2.8), start=2.4)
        reason, detail = branch.ends[1]
        assert reason == "domain"
        assert "too fast" in detail
        assert 2.5 - 1e-6 < branch.parameter[-1] <= 2.5

    def test_ctrl_c_returns_what_there_is(self):
        def made(w):
            if w > 2.5:
                signal.raise_signal(signal.SIGINT)
            return scene(frequency=w)

        branch = vi.continuation(orbit(), made, (2.3, 2.8), start=2.4, direction="up")
        assert branch.ends[1][0] == "interrupted"
        assert len(branch) > 2


class TestMonitorZeros:
    def test_zeros_of_a_monitor_are_special_points(self):
        # The speed of the impact is 3 at a force that the closed form knows.
        wanted = 3.0
        branch = vi.continuation(
            orbit(), "forcing_scale", (0.3, 1.5), monitor={"off": lambda own: own.impacts["speed_before"][0] - wanted}
        )
        (found,) = (own for own in branch.special if own.kind == "user:off")
        assert abs(miss(wanted, force=8.5 * found.parameter)) < 1e-9
        assert abs(found.orbit.impacts["speed_before"][0] - wanted) < 1e-9
        assert found.branches() == []
        arclengths = [own.arclength for own in branch.special]
        assert arclengths == sorted(arclengths)

    def test_zeros_beside_a_fold_between_two_points(self):
        # The speed goes on one way through the fold, the force back.
        numbers = {"frequency": 2.8, "clearance": -0.5}
        way = {"virtual": "keep", "step": (1e-3, 0.5, 0.5)}
        plain = vi.continuation(orbit(force=1.0, **numbers), "forcing_scale", (0.2, 2.0), **way)
        (fold,) = (own for own in plain.special if own.kind == "fold")
        there = np.flatnonzero(plain.arclength < fold.arclength)[-1]
        low, high = plain.speeds_before[there : there + 2, 0]
        for part in (0.1, 0.5, 0.9):
            wanted = low + part * (high - low)
            off = {"off": lambda own, wanted=wanted: own.impacts["speed_before"][0] - wanted}
            branch = vi.continuation(orbit(force=1.0, **numbers), "forcing_scale", (0.2, 2.0), monitor=off, **way)
            (found,) = (own for own in branch.special if own.kind == "user:off")
            assert abs(miss(wanted, force=found.parameter, **numbers)) < 1e-9

    def test_ctrl_c_in_a_monitor_keeps_the_branch(self):
        calls = []

        def measure(own):
            calls.append(own)
            if len(calls) == 5:
                raise KeyboardInterrupt
            return own.period

        with pytest.raises(KeyboardInterrupt) as raised:
            vi.continuation(orbit(), "forcing_scale", (0.3, 1.5), monitor={"period": measure})
        assert len(raised.value.branch) > 5
        assert raised.value.branch.ends[1][0] == "range"

    def test_a_jump_is_no_zero(self):
        branch = vi.continuation(
            orbit(),
            "forcing_scale",
            (0.3, 1.5),
            monitor={"side": lambda own: 1.0 if own.impacts["speed_before"][0] > 3 else -1.0},
        )
        assert not any(own.kind.startswith("user:") for own in branch.special)


class TestSwitching:
    def test_doubled_orbits_are_followed_in_the_same_factor(self):
        branch = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5))
        doubling = next(own for own in branch.special if own.kind == "period_doubling")
        (born,) = doubling.branches()
        assert born.orbit.n_periods == 2
        # Below it the orbit of one period is not stable.
        assert born.side == -1
        assert born.is_stable
        again = vi.continuation(born, "forcing_scale", (0.1, 1.5))
        by_point = vi.continuation(doubling, "forcing_scale", (0.1, 1.5))
        np.testing.assert_allclose(again.parameter, by_point.parameter)
        # It comes back to the doubling, where its two speeds are one.
        nearest = np.abs(again.parameter - doubling.parameter).argmin()
        assert abs(again.parameter[nearest] - doubling.parameter) < 1e-2
        force = again[-1].scene.forcing.amplitude[0].real
        assert abs(force - 8.5 * again.parameter[-1]) < 1e-12 * force

    def test_a_graze_bears_the_impacts_of_kappa(self):
        # kappa of one to four rounds: -0.242, 1.450, -0.843, 0.469 (x'' + 0.1 x' + x, w = 2.4, e = 0.8).
        rest = vi.periodic_orbits(scene(force=4.0), [])[0]
        branch = vi.continuation(rest, lambda force: scene(force=force), (3.0, 6.0), start=4.0)
        (graze,) = branch.special
        assert graze.kind == "graze"
        sides = {own.orbit.n_periods: own.side for own in graze.branches()}
        assert [sides[m] for m in (1, 2, 3, 4)] == [1, -1, 1, -1]
        kept = [own.orbit.n_periods for own in graze.branches() if own.is_admissible]
        assert sorted(kept) == [1, 2]
        assert not any(own.is_stable for own in graze.branches())

    def test_what_becomes_of_it_beyond(self):
        rest = vi.periodic_orbits(scene(force=4.0), [])[0]
        branch = vi.continuation(rest, "forcing_scale", (0.9, 1.5))
        found = branch.special[0].beyond()
        assert found.outcome == "nonsmooth_fold"
        assert found.attractor is not None
        assert "500 periods" in found.reason

    def test_mirror_images(self):
        stops = [vi.Stop(0, 0.5, 0.7), vi.Stop(0, 0.5, 0.7, side="lower")]
        both = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([1.0], 1.2), stops)
        found = vi.continuation(vi.periodic_orbits(both, [0, 1])[0], "frequency", (1.1, 1.8), virtual="keep")
        fork = next(own for own in found.special if own.kind == "pitchfork")
        assert abs(fork.parameter - 1.530515078983) < 1e-11
        (born,) = fork.branches()
        a, b = born.orbit, born.orbit.mirrored()
        speeds = [dict(zip(own.impacts["stop"].tolist(), own.impacts["speed_before"], strict=True)) for own in (a, b)]
        assert speeds[0][0] != pytest.approx(speeds[0][1], rel=1e-4)
        assert speeds[0][0] == pytest.approx(speeds[1][1], rel=1e-12)
        with pytest.raises(ValueError, match="mirror"):
            orbit().mirrored()
        with pytest.raises(ValueError, match="mirror image"):
            vi.continuation(orbit(), "frequency", (2.0, 2.6), symmetric=True)

    def test_an_end_names_its_boundary(self):
        branch = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5))
        assert branch.ends[0][1].startswith("lost_impact: beyond 0.56")

    def test_nothing_goes_off_a_fold(self):
        folded = vi.Scene(SYSTEM, vi.Harmonic([1.0], 2.8), vi.Stop(0, -0.5, 0.8))
        branch = vi.continuation(vi.periodic_orbits(folded, [0])[0], "forcing_scale", (0.2, 5.0))
        fold = next(own for own in branch.special if own.kind == "fold")
        assert fold.branches() == []
        with pytest.raises(ValueError, match="no branch goes off"):
            vi.continuation(fold, "forcing_scale", (0.2, 5.0))
        with pytest.raises(ValueError, match="boundary"):
            fold.beyond()

    def test_a_callable_that_was_not_saved(self, tmp_path):
        branch = vi.continuation(orbit(), lambda force: scene(force=force), (7.0, 9.0), start=8.5)
        doubling = branch.special[0]
        assert len(doubling.branches()) == 1
        again = pickle.loads(pickle.dumps(doubling))
        with pytest.raises(ValueError, match="not saved"):
            again.branches()


class TestTree:
    def test_each_branch_stands_once(self):
        tree = vi.branch_tree(orbit(), "forcing_scale", (0.3, 1.2))
        assert tree.parents[0] is None
        keys = [(own.n_periods, len(own[0].impacts)) for own in tree]
        assert (1, 0) in keys
        assert (2, 2) in keys
        assert (4, 4) in keys
        assert (2, 1) in keys
        for k, one in enumerate(tree):
            for other in tree.branches[:k]:
                if (one.n_periods, one.pattern) != (other.n_periods, other.pattern):
                    continue
                low, high = max(one.parameter.min(), other.parameter.min()), min(one.parameter.max(), other.parameter.max())
                if low < high:
                    value = 0.5 * (low + high)
                    u, w = (sorted(o.impacts["speed_before"].sum() for o in own.at(value)) for own in (one, other))
                    assert not any(abs(a - b) < 1e-6 for a in u for b in w)
        assert len(tree.at(0.75)) >= 3

    def test_workers_change_nothing(self):
        one, two = (vi.branch_tree(orbit(), "forcing_scale", (0.5, 1.2), depth=1, workers=own) for own in (1, map))
        assert one.parents == two.parents
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a.parameter, b.parameter)

    def test_not_through_boundaries(self):
        tree = vi.branch_tree(orbit(), "forcing_scale", (0.3, 1.2), through=False, depth=1)
        assert [own.n_periods for own in tree] == [1, 2]

    @pytest.mark.parametrize(("name", "value"), [("max_branches", 0), ("depth", -1), ("depth", 1.5)])
    def test_bad_counts(self, name, value):
        with pytest.raises(ValueError, match=f"{name} is"):
            vi.branch_tree(orbit(), "forcing_scale", (0.3, 1.2), **{name: value})


class TestBifurcationCurve:
    PLANE = (("frequency", "forcing_scale"), ((2.1, 3.0), (0.1, 2.0)))

    def test_doublings_lie_on_the_closed_form(self):
        doubling = next(
            own for own in vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special if own.kind == "period_doubling"
        )
        curve = vi.bifurcation_curve(doubling, *self.PLANE)
        assert curve.kind == "period_doubling"
        assert len(curve) > 10
        # The branch's own factor goes on as it is.
        assert abs(curve.y[curve.arclength == 0.0][0] - doubling.parameter) < 1e-9
        for w, factor, own in zip(curve.x, curve.y, curve, strict=True):
            assert abs(miss(own.impacts["speed_before"][0], force=8.5 * factor, frequency=w)) < 1e-9
            assert np.abs(own.floquet_multipliers + 1.0).min() < 1e-8

    def test_a_callable_gives_what_the_names_give(self):
        branch = vi.continuation(orbit(), lambda force: scene(force=force), (3.0, 9.0), start=8.5)
        doubling = next(own for own in branch.special if own.kind == "period_doubling")
        ranges = ((2.1, 3.0), (1.0, 17.0))
        start = (2.4, doubling.parameter)
        made = vi.bifurcation_curve(doubling, lambda w, force: scene(force=force, frequency=w), ranges, start=start)
        assert made.parameter_names is None
        for w, force, own in zip(made.x, made.y, made, strict=True):
            assert abs(miss(own.impacts["speed_before"][0], force=force, frequency=w)) < 1e-9

    @pytest.mark.parametrize(
        ("parameters", "between", "message"),
        [
            (("frequency", "frequency"), ((2, 3), (0, 1)), "they must be two"),
            (("frequency", "freq"), ((2, 3), (0, 1)), 'parameter is "freq"'),
            (("frequency", "clearance"), ((3, 2), (0, 2)), r"between\[0\] is \(3, 2\)"),
            (("frequency", "clearance"), ((2, 3), (2, 3)), r"between\[1\] is \(2, 3\), but the orbit is at 1"),
            (("frequency", "clearance"), (2, 3), "between"),
        ],
    )
    def test_bad_input(self, parameters, between, message):
        doubling = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[1]
        with pytest.raises(ValueError, match=message):
            vi.bifurcation_curve(doubling, parameters, between)

    def test_a_number_that_does_not_change_does_not_end_the_curve(self):
        # The force at which the stop is grazed does not depend on the restitution.
        lost = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[0]
        curve = vi.bifurcation_curve(lost, ("forcing_scale", "restitution"), ((0.1, 1.5), (0.0, 1.0)))
        assert [reason for reason, _ in curve.ends] == ["range", "range"]
        assert sorted(curve.y[[0, -1]]) == [0.0, 1.0]
        np.testing.assert_allclose(curve.x, lost.parameter, rtol=1e-9)
        assert not curve.is_virtual.any()

    def test_a_circle_closes(self):
        # Real and imaginary part of the amplitude: the doubling depends on its modulus alone.
        doubling = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[1]
        force = doubling.orbit.scene.forcing.amplitude[0].real

        def make(x, y):
            return vi.Scene(SYSTEM, vi.Harmonic([force * complex(x, y)], 2.4), vi.Stop(0, 1.0, 0.8))

        curve = vi.bifurcation_curve(doubling, make, ((-2.0, 2.0), (-2.0, 2.0)), start=(1.0, 0.0))
        assert curve.ends[1][0] == "closed"
        np.testing.assert_allclose(np.hypot(curve.x, curve.y), 1.0, rtol=1e-8)

    def test_no_point_lies_outside_the_ranges(self):
        doubling = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[1]
        (low, high), (least, most) = between = ((2.3, 2.6), (0.85, 1.1))
        curve = vi.bifurcation_curve(doubling, ("frequency", "forcing_scale"), between)
        assert ((low <= curve.x) & (curve.x <= high) & (least <= curve.y) & (curve.y <= most)).all()
        for k in (0, -1):
            assert curve.x[k] in (low, high) or curve.y[k] in (least, most)

    def test_a_start_of_another_point_is_refused(self):
        doubling = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[1]
        with pytest.raises(ValueError, match="does not close in it"):
            vi.bifurcation_curve(
                doubling, lambda w, f: scene(force=8.5 * f, frequency=w), self.PLANE[1], start=(2.4, 1.1 * doubling.parameter)
            )

    def test_what_was_followed_is_kept_when_it_is_broken_off(self):
        doubling = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[1]
        count = 0

        def make(w, factor):
            nonlocal count
            count += 1
            if count == 400:
                raise KeyboardInterrupt
            return scene(force=8.5 * factor, frequency=w)

        curve = vi.bifurcation_curve(doubling, make, self.PLANE[1], start=(2.4, doubling.parameter))
        assert curve.ends[1][0] == "interrupted"
        assert len(curve) > 3

    def test_what_has_no_curve(self):
        with pytest.raises(ValueError, match="one instant"):
            vi.bifurcation_curve(orbit(), *self.PLANE)
        with pytest.raises(TypeError, match="special is 3"):
            vi.bifurcation_curve(3, *self.PLANE)


class TestBeyond:
    def test_the_throw_of_the_kick_does_not_decide(self):
        own = vi.Scene(SYSTEM, vi.Harmonic([1.0], 1.0), vi.Stop(0, 0.3, 0.6))
        start = next(found for found in vi.periodic_orbits(own, [0]) if found.is_admissible)
        graze = next(found for found in vi.continuation(start, "frequency", (0.6, 1.5)).special if found.kind == "graze")
        verdicts = [graze.beyond(rng=k) for k in range(4)]
        assert all(found.attractor is not None for found in verdicts)
        assert {found.attractor.n_periods for found in verdicts} == {1}

    @pytest.mark.parametrize(("name", "value"), [("delta", 0.0), ("delta", np.nan), ("periods", 0), ("periods", 1.5)])
    def test_bad_input(self, name, value):
        lost = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5)).special[0]
        with pytest.raises(ValueError, match=f"{name} is"):
            lost.beyond(**{name: value})


def before(clearance):
    """A scene in which impacts become ever slower behind a release."""
    return vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([1.0], 0.5), vi.Stop(0, clearance, 0.5))


@pytest.fixture(scope="module")
def graze():
    own = before(0.25)
    found = vi.find_orbit(own, vi.simulate(own, [-0.5], [0.0], (0, 80 * own.period)))
    return vi.continuation(found, "clearance", TestAccumulation.RANGE, direction="down").special[0]


class TestAccumulation:
    RANGE = (0.0, 0.5)

    def test_the_border_is_where_bisection_has_it(self, graze):
        border = graze.accumulation()
        assert (border.kind, border.stop, border.parameter_name) == ("chatter_border", 0, "clearance")
        # Whether the impacts behind a release come to rest before the next, by halves in 34 digits.
        assert abs(border.parameter - 0.23146102702904454) < border.error < 1e-7
        assert len(border.orbit.impacts) > len(graze.orbit.impacts) + 6
        assert np.isnan(border.arclength)
        # Beyond it the impacts come to rest.
        (rests,) = border.branches()
        assert (rests.side, rests.is_admissible, rests.is_stable) == (-1, True, True)
        assert any(str(row["kind"]) == "stick" for row in rests.orbit.segments)
        assert "chatter_border" in repr(pickle.loads(pickle.dumps(border)))

    def test_a_callable_gives_what_the_name_gives(self, graze):
        orbit = vi.find_orbit(before(0.245), graze.orbit)
        found = vi.continuation(orbit, before, self.RANGE, start=0.245, direction="down").special[0]
        border, other = found.accumulation(), graze.accumulation()
        assert abs(border.parameter - other.parameter) <= border.error + other.error

    def test_what_does_not_accumulate(self, graze):
        branch = vi.continuation(orbit(), "forcing_scale", (0.1, 1.5))
        lost = branch.special[0]
        with pytest.raises(ValueError, match=r"special is lost_impact, but it must be a graze"):
            lost.accumulation()
        free = next(own for own in lost.branches() if not len(own.orbit.impacts))
        touch = vi.continuation(free, "forcing_scale", (0.1, 1.5), direction="up").special[-1]
        assert touch.kind == "graze"
        assert touch.accumulation() is None

    def test_it_is_broken_off(self, graze):
        calls = 0

        def made(clearance):
            nonlocal calls
            calls += 1
            if calls > 400:
                signal.raise_signal(signal.SIGINT)
            return before(clearance)

        orbit = vi.find_orbit(before(0.245), graze.orbit)
        found = vi.continuation(orbit, made, self.RANGE, start=0.245, direction="down").special[0]
        assert calls < 400
        with pytest.raises(KeyboardInterrupt):
            found.accumulation()


class TestInterrupt:
    def test_a_branch_that_is_broken_off_on_its_way_up_does_not_go_down(self):
        count = 0

        def make(force):
            nonlocal count
            count += 1
            if count == 40:
                raise KeyboardInterrupt
            return scene(force=force)

        branch = vi.continuation(orbit(), make, (5.0, 12.0), start=8.5)
        assert [reason for reason, _ in branch.ends] == ["start", "interrupted"]
        assert branch.parameter.min() == 8.5


@pytest.fixture(scope="module")
def family():
    system = vi.LinearSystem([1.0, 1.0], None, [[2.0, -1.0], [-1.0, 2.0]])
    own = vi.Scene(system, stops=vi.Stop(1, 1.0, 1.0))
    start = vi.find_orbit(own, ([-1.2, -1.2], [0.0, 0.0], 5.97))
    return vi.continuation(start, "energy", (0.1, 40.0))


class TestEnergy:
    def test_each_orbit_has_the_energy_that_it_is_at(self, family):
        assert family.parameter_name == "energy"
        for own, energy in zip(family, family.parameter, strict=True):
            ledger = own.energy
            np.testing.assert_allclose(ledger.kinetic + ledger.potential, energy, rtol=1e-9)
        # Both masses together reach the stop with the energy of their mode.
        assert family.special[0].kind == "lost_impact"
        assert family.special[0].parameter == pytest.approx(1.0, abs=1e-9)

    def test_stability_changes_where_something_happens(self, family):
        fold, doubling = (own.parameter for own in family.special[1:])
        after_fold = family.arclength > family.special[1].arclength
        assert not family.is_stable[~after_fold].any()
        assert family.is_stable[after_fold & (family.parameter < doubling)].all()
        assert not family.is_stable[family.parameter > doubling].any()
        assert fold < family.parameter.min() + 1e-3

    def test_goes_where_any_branch_goes(self, family, tmp_path):
        family.save(tmp_path / "family.npz")
        doubled = vi.load(tmp_path / "family.npz").special[2].branches()
        assert [own.pattern for own in doubled] == [[0, 0]]
        assert vi.continuation(doubled[0], "energy", (0.1, 40.0)).pattern == [0, 0]
        assert [own.pattern for own in vi.branch_tree(family[-1], "energy", (0.1, 40.0))][:2] == [[0], [0, 0]]
        at = family.at(0.97)
        assert len(at) == 2
        assert all(own.energy.kinetic[0] + own.energy.potential[0] == pytest.approx(0.97) for own in at)

    def test_what_has_no_family(self, family):
        with pytest.raises(ValueError, match="without forcing only"):
            vi.continuation(orbit(), "energy", (0.1, 40.0))
        with pytest.raises(ValueError, match='continue in "energy" or add damping'):
            vi.continuation(family[0], "clearance", (0.5, 2.0))
        with pytest.raises(ValueError, match="settle on nothing"):
            family.special[0].beyond()
        with pytest.raises(ValueError, match="keep their energy in any"):
            vi.bifurcation_curve(family.special[2], ("clearance", "restitution"), ((0.5, 2.0), (0.5, 1.0)))


def test_a_truth_value_is_no_number():
    with pytest.raises(TypeError, match="max_points is True, but a whole number is needed"):
        vi.continuation(orbit(), "forcing_scale", (0.5, 1.2), max_points=True)
    with pytest.raises(TypeError, match="rtol is True, but a number is needed"):
        vi.simulate(scene(), 0.0, 0.0, (0.0, 1.0), rtol=True)


def test_many_modes_are_counted():
    frequencies = 1.0 + np.arange(30)
    system = vi.LinearSystem(np.ones(30), 0.02 * frequencies, frequencies**2)
    stop = vi.Stop(1 / (1 + 0.1 * np.arange(30)), 0.3, 0.8)
    own = vi.Scene(system, vi.Harmonic(1 / frequencies, 2.4), stop)
    branch = vi.continuation(vi.periodic_orbits(own, [0])[0], "forcing_scale", (0.5, 2.0))
    assert np.isnan(branch.multipliers).all()
    exact = [np.count_nonzero(np.abs(orbit.floquet_multipliers) > 1 + 1e-9) for orbit in branch[1:-1:7]]
    np.testing.assert_array_equal(branch.n_unstable[1:-1:7], exact)
    turn = next(found for found in branch.special if found.kind == "torus")
    on_circle = np.exp(2j * np.pi * turn.data["rotation_number"])
    assert np.abs(turn.orbit.floquet_multipliers - on_circle).min() < 1e-6
    with pytest.raises(ValueError, match="only counted"):
        vi.plot.multiplier_paths(branch)


def coupled(frequency):
    """Two coordinates before two stops, with branches that begin where many impacts of a motion have little speed."""
    mass = [[1.357412237571844, 0.061958375723063515], [0.06195837572306351, 0.9450124426375573]]
    damping = [[0.11370486761505981, -0.007027803175869809], [-0.007027803175869809, 0.2239481956067742]]
    stiffness = [[0.9823686501477664, -0.5198928884781571], [-0.5198928884781571, 1.0044329199885143]]
    force = vi.Harmonic([-0.5982737052647857, -1.078591914465919], frequency, -2.9573894513460326)
    first = vi.Stop([-0.17200310675103822, -0.7118377848898774], 0.2203899210466979, 0.4, reaction="coordinate")
    second = vi.Stop([0.6112208900812348, 1.4668776242995478], 0.41725498884757306, 0.9)
    return vi.Scene(vi.LinearSystem(mass, damping, stiffness), force, [first, second])


def born_from(orbit, between, depth):
    """Follow an orbit and what is born at its boundaries."""
    branch = vi.continuation(orbit, "frequency", between)
    found = [branch]
    for point in branch.special if depth > 0 else ():
        for candidate in point.branches() if point.kind in ("graze", "lost_impact") else ():
            if candidate.is_admissible:
                found += born_from(candidate, between, depth - 1)
    return found


def test_an_orbit_at_a_value_is_one_of_that_value():
    """Its scene has the value, whatever lies between the points: the branches begin at boundaries and turn sharply there."""
    scene = coupled(2.220121579365262).replace(phase=1.1248965871357546)
    guess = ([-0.10207070952211138, -0.2849433483388223], [-0.053685485848322945, 0.12338877575763393])
    first = vi.find_orbit(scene, guess, 1)
    asked = 0
    for branch in born_from(first, (1.9542477456158283, 2.777006666326989), 2):
        ends = branch.parameter[:2], branch.parameter[-2:]
        values = np.concatenate([np.linspace(*sorted(pair), 7)[1:-1] for pair in ends])
        for value in values:
            for orbit in branch.at(float(value)):
                asked += 1
                assert abs(orbit.scene.forcing.frequency - value) <= 1e-12 * value
                np.testing.assert_allclose(orbit.period, 2.0 * np.pi * orbit.n_periods / value, rtol=1e-12)
    assert asked > 50


@pytest.mark.parametrize("seed", range(8))
def test_passages_of_a_fold_have_the_values_that_are_asked_for(seed):
    """Of one mass before a stop at both passages of its fold, near it too: the scene has the value, the motion closes in it."""
    rng = np.random.default_rng(seed)
    damping, restitution, clearance = rng.uniform(0.05, 0.3), rng.uniform(0.4, 0.95), -rng.uniform(0.2, 1.0)
    frequency = rng.uniform(2.1, 2.9)
    scene = vi.Scene(vi.LinearSystem([1.0], damping, 1.0), vi.Harmonic([10.0], frequency), vi.Stop(0, clearance, restitution))
    orbits = vi.periodic_orbits(scene, [0])
    if not len(orbits):
        pytest.skip("no orbit")
    branch = vi.continuation(orbits[0], "forcing_scale", (0.01, 1.5), virtual="keep")
    ends = [float(branch.parameter.min()), float(branch.parameter.max())]
    for value in [*rng.uniform(*ends, 6), ends[0] + 1e-9 * (ends[1] - ends[0])]:
        for orbit in branch.at(float(value)):
            np.testing.assert_allclose(np.abs(orbit.scene.forcing.amplitude), 10.0 * value, rtol=1e-13)
            run = vi.simulate(orbit.scene.replace(stops=[]), orbit.q0, orbit.v0, (0.0, orbit.period))
            np.testing.assert_allclose(run.final[0], orbit.q0, atol=1e-9 * orbit.max_displacement.max())
