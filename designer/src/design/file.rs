//! The design file `design.json`: everything the detector is told, and everything a third party
//! needs to check it.
//!
//! # Conventions
//! - Matrices are arrays of rows, gains in the rules' order of [`steerguard_detector`].
//! - Numbers are written so that they read back bit for bit; the same specification gives the same
//!   bytes.
//! - `hash` is the SHA-256 of the content, [`steerguard_verify::content_hash`]. Layout may change
//!   freely, numbers may not.
//! - `detector` is all that is baked, so one hash is one detector; zero has no sign in what is read.
//! - docs/formats.md describes the keys for those who read the file without this crate. A key of
//!   `detector` more or less is another [`FORMAT`].
//! - Keys without a value yet are null.

use std::io;

use serde::{Deserialize, Serialize};
use serde_json::ser::{Formatter, Serializer};
use steerguard_detector::{Configuration, ConfigurationError, RULES};
use steerguard_verify::Refusal;
use steerguard_world::GRAVITY_M_PER_S2;

use crate::analysis::certificate::{Check, Margin};
use crate::analysis::certified::{APosteriori, CertifiedFigures};
use crate::analysis::estimate::EstimateFigures;
use crate::analysis::frequency::{Frozen, PointFigures};
use crate::document::Mistakes;
use crate::lmi::matrix::Rows3;
use crate::search::SearchRecord;
use crate::sight::Sight;
use crate::spec::{AIR_KG_PER_M3, Fault, MethodName, Spec, ThresholdKind};
use crate::threshold::calibration::Level;
use crate::threshold::guaranteed::{Guaranteed, PeakCertificate};
use crate::threshold::recorded::Recorded;
use crate::threshold::searched::Searched;
use crate::threshold::second::SecondLevels;

/// Value of the key `format`.
pub const FORMAT: &str = "steerguard-design/4";
/// What the formats of all versions begin with.
const ANY_FORMAT: &str = "steerguard-design/";

/// A design: gains, threshold, what they are worth and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Design {
    /// [`FORMAT`].
    pub format: String,
    /// Constants that numbers of `detector` are made with.
    pub constants: Constants,
    /// The specification, all defaults filled in.
    pub spec: Spec,
    /// What the detector is told: every number that is baked.
    pub detector: Configuration,
    /// A_i and gains of the rules.
    pub vertices: [Rule; RULES],
    /// B, 3 x 2.
    #[serde(rename = "B")]
    pub b: [[f64; 2]; 3],
    /// G, 3 x 1.
    #[serde(rename = "G")]
    pub g: [[f64; 1]; 3],
    /// C, 2 x 3.
    #[serde(rename = "C")]
    pub c: [[f64; 3]; 2],
    /// D, 3 x n_d: a column of each disturbance, per unit.
    #[serde(rename = "D")]
    pub d: Vec<Vec<f64>>,
    /// D_y, 2 x n_y: a column of each bounded sensor noise, per m/s or rad/s; null without.
    #[serde(rename = "D_y")]
    pub d_y: Option<Vec<Vec<f64>>>,
    /// F, 3 x n_f: a column of each fault, per rad or N m.
    #[serde(rename = "F")]
    pub f: Vec<Vec<f64>>,
    /// What the threshold rests on.
    pub threshold: ThresholdRecord,
    /// How the gains were found.
    pub synthesis: SynthesisRecord,
    /// What the gains are worth.
    pub performance: Performance,
    /// The matrices that prove it.
    pub certificate: Certificate,
    /// See the module's conventions.
    pub hash: String,
}

/// Constants of nature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constants {
    /// Standard acceleration of gravity.
    pub gravity_m_per_s2: f64,
    /// Density of air.
    pub air_density_kg_per_m3: f64,
}

impl Constants {
    /// Those that designs are made with.
    pub const USED: Self =
        Self { gravity_m_per_s2: GRAVITY_M_PER_S2, air_density_kg_per_m3: AIR_KG_PER_M3 };
}

/// A rule: its vertex and gains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// A_i, 3 x 3.
    #[serde(rename = "A")]
    pub a: Rows3,
    /// N_i, 3 x 3.
    #[serde(rename = "N")]
    pub n: Rows3,
    /// L_i, 3 x 2.
    #[serde(rename = "L")]
    pub l: [[f64; 2]; 3],
    /// H_i, 3 x 2.
    #[serde(rename = "H")]
    pub h: [[f64; 2]; 3],
}

/// What the threshold and its start-up term rest on; the numbers themselves are in `detector`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThresholdRecord {
    /// How the threshold was found.
    pub kind: ThresholdKind,
    /// Margin over the levels below.
    pub margin: f64,
    /// The start-up term.
    pub start_up: StartUpRecord,
    /// The largest fault-free J, less the start-up term, of the specified vehicle; its drives are
    /// described in `spec.evaluation.calibration`. Of kinds "calibrated" and "adaptive".
    pub calibration: Option<Level>,
    /// The largest ratio of J to that level and the uncertainties' bound, start-up term aside, in the
    /// same drives of uncertain vehicles. Of kind "adaptive".
    pub uncertain: Option<Level>,
    /// What the drives of `spec.evaluation.calibration.drives` reach likewise: J of kind "calibrated", that
    /// ratio of kind "adaptive".
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recorded: Vec<Recorded>,
    /// The largest such ratio that a short search finds, family by family. Of kind "adaptive".
    pub searched: Vec<Searched>,
    /// The largest statistics of the second test; none where it does not run.
    pub second: Option<SecondLevels>,
    /// Of kind "guaranteed", the bound and its causes.
    pub guaranteed: Option<Guaranteed>,
}

/// What proves the bound on the start-up residual.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartUpRecord {
    /// P_i of the bound, see [`crate::analysis::start_up`].
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
    /// Margin of its inequalities.
    pub margin: Margin,
}

/// How the gains were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SynthesisRecord {
    /// Method.
    pub method: MethodName,
    /// alpha_d: with alpha_f and V what the synthesis had, given or found.
    pub alpha_d: f64,
    /// alpha_f.
    pub alpha_f: f64,
    /// V, 1 x 3.
    #[serde(rename = "V")]
    pub v: Vec<Vec<f64>>,
    /// gamma of (31), per unit of the first disturbance: the smallest for this beta. Method "gap"
    /// goes on from this synthesis.
    pub gamma: f64,
    /// beta of (32), per rad or N m.
    pub beta: f64,
    /// What no beta of (32) exceeds.
    pub beta_bound: f64,
    /// `beta / gamma`, each channel in units of its smallest fault and of its bound.
    pub gap: f64,
    /// The solver.
    pub solver: String,
    /// What the design may be called.
    pub status: DesignStatus,
    /// What the proof misses where that is not "certified"; null where it is.
    pub unproven: Option<String>,
    /// What the solver said of it.
    pub solver_status: String,
    /// The solver's iterations.
    pub iterations: u32,
    /// The paper's own problem: the largest beta for a given gamma. No gains are taken from it; null
    /// for method "gap".
    pub largest_beta: Option<LargestBeta>,
    /// The search of method "gap"; null for method "paper".
    pub search: Option<SearchRecord>,
}

/// Result of "maximise beta subject to (31)-(33)".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LargestBeta {
    /// gamma held.
    pub gamma: f64,
    /// Largest beta.
    pub beta: f64,
    /// What the solver said: its solutions lie on the boundary of the feasible set.
    pub solver_status: String,
    /// The solver's iterations.
    pub iterations: u32,
}

/// What a design may be called.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum DesignStatus {
    /// `performance.certified` is proven for the stored gains in exact arithmetic, by
    /// [`steerguard_verify::verify`].
    Certified,
    /// The solver says solved; there is no proof.
    Uncertified,
    /// The solver says almost solved; there is no proof.
    AlmostSolved,
    /// Proven or not, its own drives miss the smallest fault of interest: see [`Sight::blind`].
    Blind,
}

/// What the gains are worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Performance {
    /// The gap that no residual generator exceeds, at the worst operating point; null: unbounded.
    /// See [`crate::analysis::frequency::limit`].
    pub limit: Option<f64>,
    /// Residual of the smallest fault against that of disturbances and noise, at the worst operating
    /// point. See [`crate::analysis::frequency::detection_ratio`].
    pub detection_ratio: f64,
    /// RMS of the weighted residual under white sensor noise, at the worst operating point. See
    /// [`crate::analysis::frequency::noise_rms`].
    pub noise_rms: f64,
    /// Worst gains at frozen operating points.
    pub frozen: FrozenRecord,
    /// Certified for the gains as stored, with free multipliers; null where there is no
    /// certificate.
    pub certified: Option<CertifiedFigures>,
    /// The norm that the figures above are in.
    pub norm: String,
    /// Spectral radius of each N_i.
    pub spectral_radii: [f64; RULES],
    /// Frozen beta times the smallest fault of interest: what J tends to, at least.
    pub smallest_fault_residual: f64,
    /// The decay rate of the error that the gains were made for, a sample: the stated one or what the
    /// search found.
    pub decay: f64,
    /// What the fault that is designed for does to the estimated lateral speed; null for torque.
    pub estimate: Option<EstimateFigures>,
    /// The figures at every operating point of the grid.
    pub operating_points: Vec<PointFigures>,
    /// The faults that the gains were not made for.
    pub other_faults: Vec<FaultFigures>,
    /// What the detector sees in simulated drives; null where the first fault is one of the drive torque.
    pub sight: Option<Sight>,
}

/// What the gains are worth for a fault that they were not made for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultFigures {
    /// The fault.
    pub fault: Fault,
    /// As in [`Performance`].
    pub limit: Option<f64>,
    /// As in [`Performance`].
    pub detection_ratio: f64,
    /// As in [`Performance`].
    pub frozen: FrozenRecord,
}

/// Frozen gains and their ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenRecord {
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// What lies between the frequencies of the grid included.
    pub beta_at_least: f64,
    /// Largest gain from the disturbances over their band, per unit of the first.
    pub gamma: f64,
    /// What lies between the frequencies of the grid included; null: the grid is too coarse for a bound.
    pub gamma_at_most: Option<f64>,
    /// `beta / gamma`, each channel in units of its smallest fault and of its bound.
    pub gap: f64,
}

impl FrozenRecord {
    /// With the gap of `frozen` in units of the smallest fault and the first bound.
    pub fn new(frozen: Frozen, smallest_fault: f64, bound: f64) -> Self {
        let Frozen { beta, beta_at_least, gamma, gamma_at_most } = frozen;
        let gap = beta * smallest_fault / (gamma * bound);
        let gamma_at_most = gamma_at_most.is_finite().then_some(gamma_at_most);
        Self { beta, beta_at_least, gamma, gamma_at_most, gap }
    }
}

/// The matrices that prove what the gains are worth. Those of (31) and (32) are null where the gains
/// are not those of a synthesis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// What (31)-(33) prove if their check holds, in words.
    pub statement: Option<String>,
    /// P_s,i: the decay of the error.
    #[serde(rename = "P_s")]
    pub p_s: [Rows3; RULES],
    /// Of (31), for each band of the disturbances.
    pub attenuation: Option<Vec<AttenuationRecord>>,
    /// P_f,i of (32).
    #[serde(rename = "P_f")]
    pub p_f: Option<[Rows3; RULES]>,
    /// Q of (32).
    #[serde(rename = "Q_f")]
    pub q_f: Option<Rows3>,
    /// R.
    #[serde(rename = "R")]
    pub r: Option<Rows3>,
    /// Margins of (13), (31)-(33) at these matrices and the gains above.
    pub margins: Option<Check>,
    /// The matrices behind `performance.certified`, with P_s for its decay; null where there are
    /// none.
    pub a_posteriori: Option<APosteriori>,
    /// The numbers behind `threshold.guaranteed`, for each of its inputs; null for other kinds.
    pub peaks: Option<Vec<PeakCertificate>>,
}

/// The matrices of (31) for a band of the disturbances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AttenuationRecord {
    /// gamma of the band.
    pub gamma: f64,
    /// P_d,i.
    #[serde(rename = "P_d")]
    pub p_d: [Rows3; RULES],
    /// Q.
    #[serde(rename = "Q_d")]
    pub q_d: Rows3,
}

/// Why a design file is refused.
#[derive(Debug, thiserror::Error)]
pub enum DesignFileError {
    /// Not a design of this version, or changed after it was written.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A key is missing, unknown or of another form.
    #[error("not a design file of format \"{FORMAT}\": {0}")]
    Key(#[from] serde_path_to_error::Error<serde_json::Error>),
    /// A specification that this version does not read.
    #[error("the specification inside the design of format \"{format}\": {source}")]
    OldSpec {
        /// The design's format.
        format: String,
        /// What stands in the way.
        source: serde_path_to_error::Error<serde_json::Error>,
    },
    /// Its specification is not possible.
    #[error("in `spec`: {0}")]
    Spec(#[from] Mistakes),
    /// Its numbers cannot run.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
}

impl Design {
    /// The file's text.
    ///
    /// # Errors
    /// [`serde_json::Error`], which no design made here causes.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        let mut bytes = Vec::new();
        self.serialize(&mut Serializer::with_formatter(&mut bytes, Layout::default()))?;
        bytes.push(b'\n');
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Reads a design; refuses another format and another hash than its content's. That the content
    /// agrees with itself is for [`steerguard_verify::verify`] to say.
    ///
    /// # Errors
    /// [`DesignFileError`], which says what is wrong.
    pub fn from_json(text: &str) -> Result<Self, DesignFileError> {
        let (content, _) = steerguard_verify::content(text)?;
        let design: Self = serde_path_to_error::deserialize(content)?;
        design.spec.check()?;
        design.detector.check()?;
        Ok(design)
    }

    /// The specification inside a design of this or an earlier version, whose hash is not looked at.
    ///
    /// # Errors
    /// [`DesignFileError`] for what is no design, or holds what is no specification any more.
    pub fn spec_from_json(text: &str) -> Result<Spec, DesignFileError> {
        let (mut content, format) = steerguard_verify::parse(text)?;
        if !format.starts_with(ANY_FORMAT) {
            return Err(Refusal::Format { found: format }.into());
        }
        let spec: Spec = serde_path_to_error::deserialize(content["spec"].take())
            .map_err(|source| DesignFileError::OldSpec { format, source })?;
        spec.check()?;
        Ok(spec)
    }

    /// The hash of the content.
    ///
    /// # Errors
    /// As [`Self::to_json`].
    pub fn computed_hash(&self) -> Result<String, serde_json::Error> {
        steerguard_verify::content_hash(&serde_json::to_value(self)?)
    }

    /// What the detector is told.
    pub fn configuration(&self) -> Configuration {
        self.detector
    }
}

/// JSON with a line for each key and every array on one line.
#[derive(Default)]
struct Layout {
    depth: usize,
}

impl Layout {
    fn new_line<W: ?Sized + io::Write>(&self, writer: &mut W) -> io::Result<()> {
        write!(writer, "\n{:width$}", "", width = 2 * self.depth)
    }
}

impl Formatter for Layout {
    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        self.new_line(writer)?;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b"," })?;
        self.new_line(writer)
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b", " })
    }
}
