//! Names of what is proven: families of inequalities, and places in them.

use std::fmt;

/// A family of inequalities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// `P_s,i > 0`, `tau^2 P_s,i - N_i(rho)' P_s,k N_i(rho) > 0`: the error decays at least like
    /// tau^k.
    Decay,
    /// `P_i - C' W_r^2 C > 0`, `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`, `amplitude^2 >= P_i,22
    /// v_y^2`: the residual after a start, `||W_r r_j|| <= amplitude tau^j`.
    StartUp,
    /// beta: with `L_k(i, j) = base(P_i, P_k, Q) - [W_r C, D_r, 0]' [W_r C, D_r, 0] +
    /// diag(0, beta^2 I, 0) + He(X_jk [N_i(rho), B_i, -I])`, `Q > 0`, `L_k(i, i) < 0`,
    /// `L_k(i, j) + L_k(j, i) < 0`, for the first fault.
    FaultSensitivity,
    /// gamma of a band of the disturbances, counted from 0 in the order in which bands occur: the
    /// same with `[W_r C, D_r, 0]' [W_r C, D_r, 0] - diag(0, gamma^2 I, 0)`, at all vertices of K
    /// where the band holds bounded noise.
    DisturbanceAttenuation(usize),
    /// gamma of all frequencies and all disturbances: the same with Q = 0.
    FullBandAttenuation,
    /// The bound on J under one input `|w| <= 1`, counted from 0, with `S = [N, B]` and
    /// `P_h = sum h_i P_i`: `P_i, V_i > 0`, `energy P_i > V_i`, at the start `e_0' P_i e_0 < 1`, and at all
    /// vertices of the premise, rho and K `diag(lambda P_h, 1 - lambda) > S' P_k S` and
    /// `diag(V_h, gain^2) - [W_r C, D_r]' [W_r C, D_r] > S' V_k S`.
    Peak(usize),
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Decay => "decay",
            Self::StartUp => "start-up",
            Self::FaultSensitivity => "fault sensitivity, beta",
            Self::DisturbanceAttenuation(band) => {
                return f.pad(&format!("disturbance attenuation, gamma[{band}]"));
            }
            Self::FullBandAttenuation => "disturbance attenuation, full band",
            Self::Peak(input) => return f.pad(&format!("bound on J, input[{input}]")),
        })
    }
}

/// Place of an inequality in its family, with rules from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Combination {
    /// `P_i` or what bounds it from below.
    Rule(usize),
    /// `Q > 0`.
    Q,
    /// A rule, its successor and rho.
    Successor {
        /// Rule of this sample.
        i: usize,
        /// Rule of the next.
        k: usize,
        /// Slope of phi.
        rho: f64,
    },
    /// A vertex of premise, rho and K, and the next sample's rule.
    Vertex {
        /// Vertex.
        vertex: usize,
        /// Rule of the next sample.
        k: usize,
    },
    /// A pair of rules, their successor, rho and K.
    Pair {
        /// Rule of this sample.
        i: usize,
        /// The same or another.
        j: usize,
        /// Rule of the next.
        k: usize,
        /// Slope of phi.
        rho: f64,
        /// Vertex of K; none without bounded noise.
        vertex: Option<usize>,
    },
}

impl fmt::Display for Combination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rule(i) => write!(f, "rule i = {i}"),
            Self::Q => write!(f, "Q > 0"),
            Self::Successor { i, k, rho } => write!(f, "rules i = {i}, k = {k}, rho = {rho}"),
            Self::Vertex { vertex, k } => write!(f, "vertex {vertex} of the premise, k = {k}"),
            Self::Pair { i, j, k, rho, vertex } => {
                write!(f, "rules i = {i}, j = {j}, k = {k}, rho = {rho}")?;
                vertex.map_or(Ok(()), |vertex| write!(f, ", vertex {vertex} of K"))
            }
        }
    }
}
