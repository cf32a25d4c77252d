//! Proof check of a design file: every inequality behind its certified figures, for the gains as
//! stored, in exact rational arithmetic.
//!
//! No solver, no floating-point linear algebra, no code shared with what wrote the file: [`verify`]
//! reads `design.json` and either proves it or says what is broken.
//!
//! # What is proven
//! For x, x^ and the measured premise in S_x, the error of the stored gains obeys
//! `e+ = N(h, rho) e + B w`, `W_r r = W_r C e + D_r w` (METHOD.md 3 and 5), with w the fault or
//! the disturbances and bounded sensor noise of a band. Matrices stored in the file prove, see
//! [`Family`]: its decay; the smallest gain beta from the first fault and the largest gain gamma
//! from each band of the disturbances among errors as slow as the band (METHOD.md 5.3); gamma of
//! all disturbances for all frequencies; the bound on the residual after a start; and, where the
//! threshold is guaranteed, the bound on J (METHOD.md 6). How the gains were found plays no part.
//!
//! # Conventions
//! - i, j: rules of this sample; k: rule of the next; rho: one of its two extremes; the weighted residual is
//!   `W_r r`, `W_r = diag(evaluation.weights)`.
//! - METHOD.md is `designer/METHOD.md`.

#![forbid(unsafe_code)]

mod band;
mod channel;
mod error_dynamics;
mod exact;
mod file;
mod model;
mod peak;
mod premise;
mod proof;
mod verdict;

pub use exact::NotPositive;
pub use file::{FORMAT, content_hash};
pub use proof::{Combination, Family};
pub use verdict::{Figures, Margin, Residues, Verdict};

/// Proves the design file with the given text.
///
/// # Errors
/// [`Refusal`]: the first thing found that is not as it must be.
pub fn verify(design: &str) -> Result<Verdict, Refusal> {
    let (design, hash) = file::Design::read(design)?;
    model::check(&design)?;
    let residues = error_dynamics::residues(&design)?;
    let (figures, margins) = proof::prove(&design)?;
    Verdict::new(&design, hash, figures, residues, margins)
}

/// Why a design file is not proven.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// Not JSON, or a key is missing or of another form.
    #[error("not a design file: {0}")]
    Unreadable(#[from] serde_json::Error),
    /// Another version.
    #[error("design format \"{found}\": this version reads \"{FORMAT}\"")]
    Format {
        /// What the file says.
        found: String,
    },
    /// Changed after it was written.
    #[error("the design was changed: its hash is {stored}, its content has {computed}")]
    Hash {
        /// What the file says.
        stored: String,
        /// What its content gives.
        computed: String,
    },
    /// No gains were certified when the design was made.
    #[error("the file holds no certificate: `{key}` is null")]
    NoCertificate {
        /// The empty key.
        key: &'static str,
    },
    /// Two places that must agree do not.
    #[error("`{key}` contradicts the rest of the file")]
    Contradiction {
        /// One of them.
        key: String,
    },
    /// A matrix of another size.
    #[error("`{key}` has the wrong size: {expected} expected")]
    Shape {
        /// The matrix.
        key: &'static str,
        /// What it must have.
        expected: &'static str,
    },
    /// An empty or impossible range.
    #[error("`{key}` = {value:?} is no range of the model")]
    Range {
        /// The range.
        key: String,
        /// What the file says.
        value: [f64; 2],
    },
    /// A number that must be positive.
    #[error("`{key}` = {value} must be positive")]
    NotPositive {
        /// The number's key.
        key: String,
        /// What the file says.
        value: f64,
    },
    /// A band that is neither low, nor high, nor full.
    #[error(
        "band_hz = {band_hz:?} is no band from 0 or up to the Nyquist frequency: middle bands have \
         no proof"
    )]
    Band {
        /// What the file says.
        band_hz: [f64; 2],
    },
    /// A matrix of the model that is not the vehicle's.
    #[error(
        "`{key}`, column {column} from 0, is not what the vehicle data give: it differs by \
         {difference:.1e}"
    )]
    Model {
        /// The matrix.
        key: String,
        /// Its column.
        column: usize,
        /// Largest difference of an element.
        difference: f64,
    },
    /// Gains that are no observer of the model.
    #[error("the gains leave a residue of {residue:.1e} in {equation}: more than rounding")]
    Residue {
        /// The equation.
        equation: &'static str,
        /// Largest element.
        residue: f64,
    },
    /// A matrix that must be symmetric.
    #[error("{family}: the matrix {matrix} is not symmetric")]
    NotSymmetric {
        /// Where it is used.
        family: Family,
        /// Its name.
        matrix: &'static str,
    },
    /// The stored `2 cos(theta)` is on the wrong side of the true one.
    #[error("{family}: two_cos_theta = {stored} is not on the safe side of 2 cos(theta)")]
    Cosine {
        /// Where it is used.
        family: Family,
        /// What the file says.
        stored: f64,
    },
    /// An inequality that does not hold.
    #[error("{family}: the inequality for {combination} does not hold: {reason}")]
    Broken {
        /// Its family.
        family: Family,
        /// Its place in the family.
        combination: Combination,
        /// What its elimination met.
        reason: NotPositive,
    },
    /// A guaranteed threshold without a bound on the noise.
    #[error("noise of {sensor} is white without a bound: no threshold can be guaranteed")]
    UnboundedNoise {
        /// Its sensor.
        sensor: &'static str,
    },
    /// A figure beyond what the certificate's other figures give.
    #[error("`{key}` = {claimed} is more than is proven: {proven}")]
    Claim {
        /// The figure.
        key: &'static str,
        /// What the file says.
        claimed: f64,
        /// What holds.
        proven: f64,
    },
}
