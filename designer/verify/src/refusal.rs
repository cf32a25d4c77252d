//! Why a design file is not accepted.

use crate::exact::NotPositive;
use crate::family::{Combination, Family};
use crate::identity::FORMAT;

/// Why a design file is not proven.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// Nothing in it.
    #[error("an empty file is no design")]
    Empty,
    /// The end is missing.
    #[error("the design is cut short: {0}")]
    Truncated(serde_json::Error),
    /// Not JSON.
    #[error("not a design file: {0}")]
    Unreadable(#[from] serde_json::Error),
    /// Some other JSON.
    #[error("not a design file: the key `format` is missing")]
    NoFormat,
    /// A key is missing, unknown or of another form.
    #[error("not a design file of format \"{FORMAT}\": {0}")]
    Key(#[from] serde_path_to_error::Error<serde_json::Error>),
    /// Another version.
    #[error("a design of format \"{found}\": this version reads \"{FORMAT}\"")]
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
    /// Figures are claimed as certified of a design whose status says that they are not.
    #[error("`{key}` is claimed, but the design's status is not \"certified\"")]
    Unproven {
        /// The claim.
        key: &'static str,
    },
    /// Two places that must agree do not.
    #[error("`{key}` is {stored}, where the rest of the file gives {recomputed}")]
    Disagreement {
        /// One of them.
        key: String,
        /// What it says.
        stored: String,
        /// What it follows from says.
        recomputed: String,
    },
    /// A kind of threshold that there is not.
    #[error("`threshold.kind` = \"{found}\" is unknown")]
    Kind {
        /// What the file says.
        found: String,
    },
    /// What the threshold is to cover is nothing that its kind can.
    #[error(
        "`spec.evaluation.covers` = \"{found}\" is nothing that a threshold of kind \"{kind}\" can cover"
    )]
    Covers {
        /// What the file says.
        found: String,
        /// The kind.
        kind: String,
    },
    /// What a kind of threshold rests on is missing.
    #[error("`{key}` is null: a threshold of kind \"{kind}\" rests on it")]
    NoCause {
        /// The empty key.
        key: String,
        /// The kind.
        kind: String,
    },
    /// What another kind of threshold rests on.
    #[error("`{key}` is no part of a threshold of kind \"{kind}\"")]
    OtherCause {
        /// The key.
        key: String,
        /// The kind.
        kind: String,
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

impl Refusal {
    /// Whether there is nothing to check: the text is no design, or one of another version.
    pub fn is_unreadable(&self) -> bool {
        matches!(
            self,
            Self::Empty
                | Self::Truncated(_)
                | Self::Unreadable(_)
                | Self::NoFormat
                | Self::Key(_)
                | Self::Format { .. }
        )
    }
}
