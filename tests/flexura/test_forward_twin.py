"""The twin as a function, in Python and over UM-Bridge: its answers fit together, bad questions are refused."""

import json
import threading
from collections.abc import Iterator
from dataclasses import replace
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import emcee
import numpy as np
import pytest

import flexura
from analysis.material import LocalLaws
from analysis.recordings.frf import Frf
from analysis.updating.update import update
from app.files.bad_file import ResultFileError
from app.files.settings_toml import toml_text
from app.twins.campaign_twin import campaign_twin
from flexura.forward_twin import ForwardTwin
from flexura.um_bridge import ModelServer

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"
MATERIAL = (2.1e9, 0.39, 0.06)
LINES = np.linspace(140.0, 420.0, 57)
MASS = {"point_mass": {"mass": 1.2e-3}}
BY = ["youngs_modulus", "poisson_ratio", "loss_factor", "point_mass.mass", "plate_thickness.share"]


@pytest.fixture(scope="module")
def twin() -> ForwardTwin:
    return flexura.twin(EXAMPLE, progress=False)


def test_it_says_what_it_is_of(twin: ForwardTwin) -> None:
    assert repr(twin).startswith("<ForwardTwin 'polypropylene plate")
    assert (twin.inputs, twin.outputs, twin.band) == (("A1",), ("S1",), (100.0, 1500.0))
    assert twin.parameters["point_mass.mass"].unit == "kg"


def test_without_effects_it_answers_as_the_plain_twin(twin: ForwardTwin) -> None:
    plain = campaign_twin(twin.experiment, lambda *_: None)
    wanted = plain.frf(LocalLaws.of_material(*MATERIAL, reference=25.0), LINES)
    np.testing.assert_allclose(twin.frf(LINES, MATERIAL), wanted, atol=1e-3 * np.abs(wanted).max())


def test_a_folder_an_experiment_and_a_campaign_are_one_plate(twin: ForwardTwin) -> None:
    for same in (flexura.load(EXAMPLE), twin.experiment):
        again = flexura.twin(same, progress=False)
        np.testing.assert_array_equal(again.frf(LINES[:3], MATERIAL), twin.frf(LINES[:3], MATERIAL))


def test_a_plate_without_frfs_has_a_twin_in_the_band_declared(twin: ForwardTwin, tmp_path: Path) -> None:
    """FRFs are compared with a twin; it does not consist of them."""
    declared = twin.experiment.model_dump(mode="json", exclude_none=True, include={"title", "plate", "patch"})
    declared["acquisition"] = {"input_resistance": 305e3, "input_capacitance": 120e-12}
    (tmp_path / "plate.toml").write_text(toml_text({"format": "flexura-plate/1", **declared}))
    with pytest.raises(ResultFileError, match=r"give \[measurement\] band"):
        flexura.twin(tmp_path)
    text = toml_text({"format": "flexura-plate/1", **declared, "measurement": {"band": [100.0, 1500.0]}})
    (tmp_path / "plate.toml").write_text(text)
    again = flexura.twin(tmp_path, progress=False)
    wanted = twin.frf(LINES[:3], MATERIAL)
    np.testing.assert_allclose(again.frf(LINES[:3], MATERIAL), wanted, atol=1e-3 * np.abs(wanted).max())


@pytest.mark.parametrize(("name", "step"), list(zip(BY, (2e4, 1e-5, 1e-6, 1e-7, 1e-6), strict=True)))
def test_derivatives_are_those_of_its_frfs(twin: ForwardTwin, name: str, step: float) -> None:
    h, slopes = twin.derivatives(LINES, BY, MATERIAL, effects=MASS)
    np.testing.assert_array_equal(h, twin.frf(LINES, MATERIAL, effects=MASS))

    def at(change: float) -> Any:
        material = [m + change * (one == name) for m, one in zip(MATERIAL, BY, strict=False)]
        effects = {"point_mass": dict(MASS["point_mass"]), "plate_thickness": {"share": 0.0}}
        if "." in name:
            effect, _, parameter = name.partition(".")
            effects[effect][parameter] += change
        return twin.frf(LINES, (material[0], material[1], material[2]), effects=effects)

    difference = (at(step) - at(-step)) / (2.0 * step)
    found = slopes[BY.index(name)]
    np.testing.assert_allclose(found, difference, atol=2e-3 * np.abs(difference).max())


def test_its_matrices_answer_as_it_does(twin: ForwardTwin) -> None:
    """One patch driven at 1 V, the other on the input's resistance and capacitance."""
    m = twin.matrices(MATERIAL, effects=MASS)
    assert m.ports == ("A1", "S1")
    drive, sense = m.coupling.T
    inputs = twin.experiment.acquisition
    answers = []
    for w in 2.0 * np.pi * LINES:
        z = m.stiffness + 1j * m.structural_damping + 1j * w * m.damping - w**2 * m.mass
        y = m.capacitance[1] + inputs.input_capacitance + 1.0 / (1j * w * inputs.input_resistance)
        # Z u = -drive 1 V - sense V, and sense' u = y V
        system = np.block([[z, sense[:, None]], [sense[None, :], np.array([[-y]])]])
        answers.append(np.linalg.solve(system, np.append(-drive, 0.0))[-1])
    wanted = twin.frf(LINES, MATERIAL, effects=MASS)[0]
    np.testing.assert_allclose(answers, wanted, atol=1e-9 * np.abs(wanted).max())


def test_its_modes_are_the_poles_of_its_matrices(twin: ForwardTwin) -> None:
    modes, m = twin.modes(MATERIAL), twin.matrices(MATERIAL)
    inputs = twin.experiment.acquisition
    sense = m.coupling[:, 1]
    for pole in modes.poles[:6]:
        y = m.capacitance[1] + inputs.input_capacitance + 1.0 / (pole * inputs.input_resistance)
        z = m.stiffness + 1j * m.structural_damping + pole**2 * m.mass + np.outer(sense, sense) / y
        # near a pole the determinant goes through zero: a change of 1e-3 of the pole changes much more
        there = np.linalg.svd(z, compute_uv=False)[-1]
        away = np.linalg.svd(z + ((1.001 * pole) ** 2 - pole**2) * m.mass, compute_uv=False)[-1]
        assert there < 1e-2 * away
    # a hysteretic plate has eta / 2, but for the patches, which lose nothing
    assert np.all((modes.damping_ratio > 0.8 * 0.03) & (modes.damping_ratio < 0.03))
    np.testing.assert_allclose(np.abs(modes.shapes).max(axis=0), 1.0)


def test_shapes_are_wanted_where_one_asks_for_them(twin: ForwardTwin) -> None:
    everywhere = twin.modes(MATERIAL)
    few = everywhere.points[[40, 900, 2500]]
    some = twin.modes(MATERIAL, points=few).shapes
    ratio = everywhere.shapes[[40, 900, 2500]][:, :5] / some[:, :5]
    np.testing.assert_allclose(ratio, np.broadcast_to(ratio[0], ratio.shape), rtol=0.02)
    with pytest.raises(ValueError, match="off the plate"):
        twin.modes(MATERIAL, points=[(9.0, 9.0)])


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"material": (2e9, 0.4, -0.1)}, "E and eta above 0"),
        ({"material": (2e12, 0.4, 0.05)}, "youngs_modulus"),
        ({}, "a twin file's laws give it at a temperature"),
        ({"material": MATERIAL, "effects": {"ghost": {}}}, "'ghost' is not known; allowed: "),
        (
            {"material": MATERIAL, "effects": {"point_mass": {"weight": 1.0}}},
            "no parameter 'weight'; allowed: ",
        ),
        ({"material": MATERIAL, "effects": {"pointmass": {}}}, "not known; did you mean point_mass. allowed: "),
        (
            {"material": MATERIAL, "effects": {"point_mass": {"mas": 1e-3}}},
            "'mas'; did you mean mass. allowed: mass",
        ),
        ({"material": (2.1e9, 0.39)}, "three numbers are wanted, E in Pa, nu and eta"),
        ({"material": MATERIAL, "effects": {"point_mass": {"mass": 9.0}}}, "point_mass.mass = 9; allowed: "),
        ({"material": MATERIAL, "effects": {"point_mass": {"mass": float("nan")}}}, "point_mass.mass = nan"),
        ({"material": MATERIAL, "actuator": "A9"}, "'A9' is not one of A1"),
        ({"material": MATERIAL, "level": 0.0}, "level 0: an amplitude above 0"),
        ({"material": MATERIAL, "temperature": 293.15}, "temperature 293.15 °C: allowed is -80 to 200 °C"),
    ],
)
def test_bad_questions_are_refused_by_name(twin: ForwardTwin, asked: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        twin.frf(LINES, **asked)


@pytest.mark.parametrize("effects", [["point_mass"], "point_mass", {"point_mass": 1e-3}])
def test_effects_of_another_form_are_refused_with_the_form(twin: ForwardTwin, effects: Any) -> None:
    with pytest.raises(
        TypeError,
        match=r'effects .*: allowed is values by effect and parameter, \{"point_mass": \{"mass": 1e-3\}\}',
    ):
        twin.frf(LINES, MATERIAL, effects=effects)


def test_no_frequency_is_refused(twin: ForwardTwin) -> None:
    with pytest.raises(ValueError, match="no frequency is given"):
        twin.frf([], MATERIAL)


def test_a_run_folder_without_a_twin_file_says_what_makes_one(tmp_path: Path) -> None:
    (tmp_path / "laws.h5").touch()
    with pytest.raises(
        ResultFileError, match=r"holds no twin\.toml; make it with: flexura gap, or name the campaign"
    ):
        flexura.twin(tmp_path)


def test_unknown_derivatives_and_lines_outside_the_band_are_refused(twin: ForwardTwin) -> None:
    with pytest.raises(ValueError, match=r"'mass' is no parameter; .*allowed: youngs_modulus, "):
        twin.derivatives(LINES, ["mass"], MATERIAL)
    with pytest.raises(ValueError, match=r"no parameter; did you mean youngs_modulus\? allowed: "):
        twin.derivatives(LINES, ["youngsmodulus"], MATERIAL)
    one, slopes = twin.derivatives(LINES, "loss_factor", MATERIAL)
    assert slopes.shape == (1, *one.shape)
    with pytest.raises(ValueError, match="Hz"):
        twin.frf([5.0], MATERIAL)


def test_matrices_that_change_along_the_band_are_none(twin: ForwardTwin) -> None:
    name = next(n for n in twin.parameters if n.startswith("relaxation."))
    with pytest.raises(ValueError, match="change along the band"):
        twin.matrices(MATERIAL, effects={"relaxation": {name.partition(".")[2]: 0.02}})


@pytest.mark.parametrize("asked", ["matrices", "modes"])
def test_what_is_attached_at_a_place_has_neither_matrices_nor_modes(twin: ForwardTwin, asked: str) -> None:
    """Its matrices were those without it; its modes were refused for dashpots that were not there."""
    effects = {"mass_at_place": {"mass": 0.002, "x": 0.1, "y": 0.08}}
    with pytest.raises(ValueError, match="attached at a place"):
        getattr(twin, asked)(MATERIAL, effects=effects)


@pytest.fixture(scope="module")
def served(twin: ForwardTwin) -> Iterator[ModelServer]:
    server = flexura.serve(twin, LINES, ["youngs_modulus", "point_mass.mass"], MATERIAL, port=0)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()
    thread.join()


def told(server: ModelServer, method: str, path: str, question: dict[str, Any] | None = None) -> dict[str, Any]:
    connection = HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    connection.request(method, path, None if question is None else json.dumps(question))
    answer: dict[str, Any] = json.load(connection.getresponse())
    connection.close()
    return answer


def ask(server: ModelServer, path: str, **question: Any) -> dict[str, Any]:
    return told(server, "POST", f"/{path}", {"name": "twin", "config": {}, **question})


def test_um_bridge_answers_as_the_twin(twin: ForwardTwin, served: ModelServer) -> None:
    assert told(served, "GET", "/Info") == {"protocolVersion": 1.0, "models": ["twin"]}
    able = ask(served, "ModelInfo")["support"]
    assert able == {"Evaluate": True, "Gradient": True, "ApplyJacobian": True, "ApplyHessian": False}
    assert ask(served, "InputSizes") == {"inputSizes": [2]}
    assert ask(served, "OutputSizes") == {"outputSizes": [2 * LINES.size]}
    point = [2.0e9, 1e-3]
    h, slopes = twin.derivatives(
        LINES,
        ["youngs_modulus", "point_mass.mass"],
        (2.0e9, *MATERIAL[1:]),
        effects={"point_mass": {"mass": 1e-3}},
    )
    both = [np.concatenate([one.real.ravel(), one.imag.ravel()]) for one in (h, *slopes)]
    np.testing.assert_array_equal(ask(served, "Evaluate", input=[point])["output"][0], both[0])
    sens = np.arange(2.0 * LINES.size)
    gradient = ask(served, "Gradient", input=[point], outWrt=0, inWrt=0, sens=sens.tolist())["output"]
    np.testing.assert_allclose(gradient, [sens @ both[1], sens @ both[2]])
    along = ask(served, "ApplyJacobian", input=[point], outWrt=0, inWrt=0, vec=[1e7, 1e-4])["output"]
    np.testing.assert_allclose(along, 1e7 * both[1] + 1e-4 * both[2])


@pytest.mark.parametrize(
    ("path", "question", "message"),
    [
        ("Evaluate", {"input": [[1.0]]}, "2 finite numbers are wanted, 1 came"),
        ("Evaluate", {"input": [[1e3, 0.0]]}, "youngs_modulus"),
        ("Evaluate", {"input": [["a", 0.0]]}, "input.0.0"),
        ("Evaluate", {"name": "other", "input": [[2e9, 0.0]]}, "allowed: twin"),
        ("Gradient", {"input": [[2e9, 0.0]], "outWrt": 1, "inWrt": 0, "sens": [1.0]}, "outWrt"),
        ("Gradient", {"input": [[2e9, 0.0]], "outWrt": 0, "inWrt": 0, "sens": [1.0]}, "sens: 114 finite numbers"),
        ("ApplyHessian", {"input": [[2e9, 0.0]]}, "allowed: Evaluate, Gradient, ApplyJacobian"),
    ],
)
def test_um_bridge_says_what_is_wrong(
    served: ModelServer, path: str, question: dict[str, Any], message: str
) -> None:
    error = ask(served, path, **question)["error"]
    assert error["type"] == "InvalidInput"
    assert message in error["message"]


@pytest.mark.slow
def test_a_public_samplers_posterior_is_as_wide_as_update_says(twin: ForwardTwin) -> None:
    """E, nu and eta of one noisy sweep: emcee asks the twin over UM-Bridge, `update` fits it."""
    rng, gain, lines = np.random.default_rng(5), 14.3, np.linspace(100.0, 600.0, 151)
    clean = gain * twin.frf(lines, MATERIAL)[None]
    variance = np.full(clean.shape, (0.01 * np.abs(clean)).mean() ** 2)
    error = rng.standard_normal((2, *clean.shape)) * np.sqrt(variance / 2.0)
    h = clean + error[0] + 1j * error[1]
    one, none = np.ones(1), np.zeros(lines.size, dtype=bool)
    frf = Frf(25.0 * one, ("up",), one, lines, h, variance, np.ones(h.shape), none, twin.outputs)
    fitted = update(frf, replace(twin.model, tolerances={}, library={}))
    centre, sigma = np.array([[*vars(rows).values()] for rows in (fitted.material, fitted.sigma)])[..., 0]

    server = flexura.serve(twin, lines, ["youngs_modulus", "poisson_ratio", "loss_factor"], MATERIAL, port=0)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()

    def log_posterior(u: Any) -> float:
        """Flat priors; the gain, which enters linearly, is integrated out."""
        answered = np.array(ask(server, "Evaluate", input=[(centre + sigma * u).tolist()])["output"][0])
        m = answered[: lines.size] + 1j * answered[lines.size :]
        weight = 1.0 / variance[0, 0]
        power, both = (weight * np.abs(m) ** 2).sum(), (weight * (np.conj(m) * h[0, 0]).real).sum()
        return float(both**2 / power - (weight * np.abs(h[0, 0]) ** 2).sum() - 0.5 * np.log(power))

    shape = 1.4 * np.linalg.cholesky(fitted.correlation[0][:3, :3])

    def proposed(u: Any, random: Any) -> tuple[Any, Any]:
        """Independent of where the walker is, beside and wider than what `update` says; Metropolis corrects it."""
        new = (0.2 + random.standard_normal(u.shape)) @ shape.T
        density = [-0.5 * ((np.linalg.solve(shape, one.T) - 0.2) ** 2).sum(0) for one in (u, new)]
        return new, density[0] - density[1]

    walkers = rng.standard_normal((8, 3))
    sampler = emcee.EnsembleSampler(8, 3, log_posterior, moves=emcee.moves.MHMove(proposed))
    sampler.random_state = np.random.RandomState(3).get_state()
    sampler.run_mcmc(walkers @ shape.T, 200)
    server.shutdown()
    server.server_close()
    thread.join()
    drawn = sampler.get_chain(discard=20, flat=True)
    assert sampler.acceptance_fraction.mean() > 0.4
    np.testing.assert_allclose(drawn.mean(axis=0), 0.0, atol=0.15)
    np.testing.assert_allclose(drawn.std(axis=0), 1.0, atol=0.1)


def test_um_bridge_is_for_this_computer_only(served: ModelServer) -> None:
    assert served.server_address[0] == "127.0.0.1"
    connection = HTTPConnection("127.0.0.1", served.server_port, timeout=10)
    for headers, status in (({"Host": "elsewhere.example:80"}, 421), ({"Content-Length": str(10**12)}, 400)):
        connection.putrequest("POST", "/Evaluate", skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        assert answer.status == status
        answer.read()
        connection.close()


def test_what_cannot_be_served_is_refused_before_the_port_is_taken(twin: ForwardTwin) -> None:
    with pytest.raises(ValueError, match="parameters 'mass': names, each once, of youngs_modulus"):
        flexura.serve(twin, LINES, ["mass"], MATERIAL, port=0)
    with pytest.raises(ValueError, match="Hz"):
        flexura.serve(twin, [1e6], ["youngs_modulus"], MATERIAL, port=0)
