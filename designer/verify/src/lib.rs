//! Check of a design file: every inequality behind its certified figures, for the gains as stored, in
//! exact rational arithmetic, and every other figure that follows from the file.
//!
//! No solver, no floating-point linear algebra, no code shared with what wrote the file: [`verify`]
//! reads `design.json` and either proves it or says what is broken.
//!
//! # What is proven
//! For x, x^ and the measured premise in S_x, the error of the stored gains obeys
//! `e+ = N(h, rho) e + B w`, `W_r r = W_r C e + D_r w` (method 3 and 5), with w the fault or
//! the disturbances and bounded sensor noise of a band. Matrices stored in the file prove, see
//! [`Family`]: its decay; the smallest gain beta from the first fault and the largest gain gamma
//! from each band of the disturbances among errors as slow as the band (method 5.3); gamma of
//! all disturbances for all frequencies; the bound on the residual after a start; and, where the
//! threshold is guaranteed, the bound on J (method 6). How the gains were found plays no part.
//!
//! # What is recomputed
//! The model and the section `detector`, which is all that is baked, from specification and constants;
//! threshold and share from the levels that they rest on; gaps, detection ratios and the like from
//! gains, noise and bounds. [`Verdict::unchecked`] names what neither holds for: what was simulated, or
//! searched on a grid.
//!
//! # Conventions
//! - i, j: rules of this sample; k: rule of the next; rho: one of its two extremes; the weighted residual is
//!   `W_r r`, `W_r = diag(evaluation.weights)`.
//! - "method N" is chapter N of `docs/method`.

#![forbid(unsafe_code)]

mod agreement;
mod band;
mod channel;
mod decay;
mod detector;
mod dynamics;
mod exact;
mod family;
mod figures;
mod frozen;
mod gains;
mod identity;
mod model;
mod peaks;
mod premise;
mod proof;
mod read;
mod refusal;
mod tally;
mod verdict;

pub use dynamics::Residues;
pub use exact::NotPositive;
pub use family::{Combination, Family};
pub use identity::{FORMAT, content_hash};
pub use proof::Figures;
pub use read::{Status, content, parse};
pub use refusal::Refusal;
pub use tally::Margin;
pub use verdict::Verdict;

/// Checks the design file with the given text: proves what is claimed as certified and recomputes what
/// follows from the rest. A design that says of itself that it is not certified is accepted as such,
/// with [`Verdict::figures`] none.
///
/// # Errors
/// [`Refusal`]: the first thing found that is not as it must be.
pub fn verify(design: &str) -> Result<Verdict, Refusal> {
    let (design, hash) = read::Design::read(design)?;
    model::check(&design)?;
    detector::check(&design)?;
    let residues = dynamics::residues(&design)?;
    let proof = proof::prove(&design)?;
    figures::check(&design)?;
    frozen::check(&design)?;
    Verdict::new(&design, hash, residues, proof)
}
