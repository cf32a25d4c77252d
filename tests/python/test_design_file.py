"""The design file's matrices against each other and against the vehicle's equations."""

import numpy as np
import pytest
from cases import Case


@pytest.fixture(scope="module")
def states(reference):
    """Random x = [v_x, v_y, r] in S_x and u = [T_eng, delta]."""
    rng = np.random.default_rng(41)
    x = rng.uniform(reference.bounds[:, 0], reference.bounds[:, 1], (1000, 3))
    u = rng.uniform([-2000.0, -0.1], [2000.0, 0.1], (1000, 2))
    return list(zip(x, u, strict=True))


def test_model_has_the_reference_entries(reference):
    case = Case("model")
    for (fast, _), a in zip(reference.corners, reference.A, strict=True):
        speed = "30_m_per_s" if fast else "5_m_per_s"
        case.check(f"a_22_at_{speed}", a[1, 1])
        case.check(f"a_32_at_{speed}", a[2, 1])
    case.check("f_2_per_rad", reference.B[1, 1])
    case.check("f_3_per_rad", reference.B[2, 1])


def test_gains_are_those_of_table_2(reference, design):
    identity = np.eye(3)
    np.testing.assert_array_equal(reference.C, [[1, 0, 0], [0, 0, 1]])
    np.testing.assert_allclose(reference.M, identity + reference.E @ reference.C, atol=1e-12)
    for a, n, l, vertex in zip(reference.A, reference.N, reference.L, design["vertices"], strict=True):
        h = np.array(vertex["H"])
        # H_i = L_i + N_i E: (34), corrected.
        np.testing.assert_allclose(h, l + n @ reference.E, atol=1e-10)
        np.testing.assert_allclose(n, reference.M @ a - h @ reference.C, atol=1e-10)
        condition = reference.M @ a - n @ reference.M - l @ reference.C
        assert np.abs(condition).max() < 1e-10, "(13)"


def test_observer_is_stable_at_every_rule(reference):
    for n in reference.N:
        assert np.abs(np.linalg.eigvals(n)).max() < 1.0


def test_blend_is_the_euler_step_of_the_nonlinear_model(reference, states):
    """(7) equals x + T_s f(x, u) of (3) inside S_x, f written here from forces and geometry."""
    d = reference
    c_y = -d.G[1] * d.mass / d.period
    for x, u in states:
        v_x, v_y, r = x
        t_eng, delta = u
        front = 2 * d.c_f * (delta - (v_y + d.l_f * r) / v_x)
        rear = 2 * d.c_r * (d.l_r * r - v_y) / v_x
        euler = x + d.period * np.array(
            [
                (t_eng - d.c_x * v_x**2) / d.longitudinal_inertia + v_y * r,
                (front + rear - c_y * v_y**2) / d.mass - v_x * r,
                (d.l_f * front - d.l_r * rear) / d.yaw_inertia,
            ]
        )
        y = d.C @ x
        h = d.membership(y)
        assert (h >= 0).all() and h.sum() == pytest.approx(1.0, abs=1e-12)
        blend = np.tensordot(h, d.A, axes=1) @ x + d.consequent(y) + d.B @ u + d.G * v_y**2
        np.testing.assert_allclose(blend, euler, atol=1e-12 * np.abs(x).max())


def test_estimate_follows_the_model_it_is_built_on(reference, states):
    """Error dynamics of method 3: e+ = (N(h) + M G rho) e without fault and disturbance."""
    d = reference
    rng = np.random.default_rng(42)
    for x, u in states[:200]:
        y = d.C @ x
        e = np.array([0.0, rng.uniform(-0.3, 0.3), 0.0])
        z = x - e + d.E @ y
        x_hat, z_next = d.observer_step(z, y, u)
        np.testing.assert_allclose(x_hat, x - e, atol=1e-12 * np.abs(x).max())
        h = d.membership(y)
        x_next = np.tensordot(h, d.A, axes=1) @ x + d.consequent(y) + d.B @ u + d.G * x[1] ** 2
        rho = np.array([0.0, x[1] + x_hat[1], 0.0])
        error_matrix = np.tensordot(h, d.N, axes=1) + np.outer(d.M @ d.G, rho)
        e_next = x_next - (z_next - d.E @ (d.C @ x_next))
        np.testing.assert_allclose(e_next, error_matrix @ e, atol=1e-11 * np.abs(x).max())
