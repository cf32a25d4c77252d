//! `[evaluation.calibration]`: the drives that the threshold is found from.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::document::{Allowed, Mistake, Mistakes};

/// Most drives.
const MOST_DRIVES: usize = 100_000;
/// Drives of a family that make a search.
const SEARCH_DRIVES: RangeInclusive<u64> = 400..=1_000_000;
/// Most recorded drives.
const MOST_RECORDED: usize = 1000;
/// Initial lateral speeds where none are stated, m/s.
const INITIAL_V_Y_M_PER_S: [f64; 3] = [-1.0, 0.0, 1.0];

/// `[evaluation.calibration]`: every manoeuvre at every speed and lateral acceleration, under every
/// frequency and phase of the disturbances, from every initial lateral speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Calibration {
    /// Number of initial speeds, evenly spread over the armed range; default 7.
    pub speeds: usize,
    /// Manoeuvres; default all.
    pub manoeuvres: Vec<Manoeuvre>,
    /// Steady-state lateral accelerations that the steering amplitudes correspond to;
    /// default [1, 2, 3].
    pub lateral_acceleration_m_per_s2: Vec<f64>,
    /// Fastest steering, at the road wheel: amplitudes are reduced to it; default 0.3.
    pub steering_rate_rad_per_s: f64,
    /// Number of frequencies, evenly spread over each disturbance's band; default 3.
    pub disturbance_frequencies: usize,
    /// Number of phases, evenly spread over a period; default 4.
    pub disturbance_phases: usize,
    /// Initial lateral speeds; default [-1, 0, 1], cut to the range of v_y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_v_y_m_per_s: Option<Vec<f64>>,
    /// Length of a drive; default 8.
    pub duration_s: f64,
    /// Drives that the search for the worst case takes of each family, threshold "adaptive"; 0: the drives
    /// above decide alone; default 500.
    pub search_drives: u64,
    /// Files of recorded fault-free drives that count beside the simulated ones, of thresholds "calibrated"
    /// and "adaptive"; relative to the specification's folder; default none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drives: Vec<String>,
    /// File that says what is in their columns, relative likewise; default: guessed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<String>,
}

impl Default for Calibration {
    fn default() -> Self {
        use Manoeuvre::{LaneChange, Sine, StepSteer, Straight, Weave};
        Self {
            speeds: 7,
            manoeuvres: vec![Straight, Sine, Weave, StepSteer, LaneChange],
            lateral_acceleration_m_per_s2: vec![1.0, 2.0, 3.0],
            steering_rate_rad_per_s: 0.3,
            disturbance_frequencies: 3,
            disturbance_phases: 4,
            initial_v_y_m_per_s: None,
            duration_s: 8.0,
            search_drives: 500,
            drives: Vec::new(),
            columns: None,
        }
    }
}

/// A course of the road-wheel angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Manoeuvre {
    /// No steering.
    Straight,
    /// Sine of 0.5 rad/s: the paper's.
    Sine,
    /// Sine of 0.2 Hz: the weave of ISO 13674.
    Weave,
    /// From 1 s on at the steering rate to the full angle, then held: the step of ISO 7401.
    StepSteer,
    /// One period of a 0.5 Hz sine from 1 s on.
    LaneChange,
}

impl Calibration {
    /// Manoeuvres with their lateral accelerations, m/s^2.
    pub fn courses(&self) -> impl Iterator<Item = (Manoeuvre, f64)> {
        self.manoeuvres.iter().flat_map(|&manoeuvre| {
            let accelerations = match manoeuvre {
                Manoeuvre::Straight => &[0.0],
                _ => self.lateral_acceleration_m_per_s2.as_slice(),
            };
            accelerations.iter().map(move |&a_y| (manoeuvre, a_y))
        })
    }

    /// Initial lateral speeds, m/s, for lateral speeds in a range around 0.
    pub fn initial_v_y_in(&self, [min, max]: [f64; 2]) -> Vec<f64> {
        let cut = || INITIAL_V_Y_M_PER_S.map(|v_y| v_y.max(min).min(max)).to_vec();
        self.initial_v_y_m_per_s.clone().unwrap_or_else(cut)
    }

    /// Number of drives under so many disturbances.
    pub fn drives(&self, disturbances: usize) -> usize {
        let signs = 1_usize << disturbances.saturating_sub(1);
        [
            self.disturbance_frequencies,
            self.disturbance_phases,
            signs,
            self.initial_v_y_m_per_s.as_ref().map_or(INITIAL_V_Y_M_PER_S.len(), Vec::len),
        ]
        .into_iter()
        .fold(self.speeds.saturating_mul(self.courses().count()), usize::saturating_mul)
    }

    /// Finds what is not possible by itself.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        for (key, count) in [
            ("speeds", self.speeds),
            ("disturbance_frequencies", self.disturbance_frequencies),
            ("disturbance_phases", self.disturbance_phases),
            ("manoeuvres", self.manoeuvres.len()),
            ("lateral_acceleration_m_per_s2", self.lateral_acceleration_m_per_s2.len()),
            ("initial_v_y_m_per_s", self.initial_v_y_m_per_s.as_ref().map_or(1, Vec::len)),
        ] {
            mistakes.unless((1..=100).contains(&count), || {
                let key = format!("evaluation.calibration.{key}");
                Mistake::value(key, count, "from 1 to 100 of them")
            });
        }
        for (index, &a_y) in self.lateral_acceleration_m_per_s2.iter().enumerate() {
            let key = format!("evaluation.calibration.lateral_acceleration_m_per_s2[{index}]");
            mistakes.number(&key, a_y, Allowed::POSITIVE);
        }
        let rate = self.steering_rate_rad_per_s;
        let key = "evaluation.calibration.steering_rate_rad_per_s";
        mistakes.number(key, rate, Allowed::POSITIVE);
        let duration_s = Allowed::between(2.0, 3600.0);
        mistakes.number("evaluation.calibration.duration_s", self.duration_s, duration_s);
        let searched = self.search_drives;
        mistakes.unless(searched == 0 || SEARCH_DRIVES.contains(&searched), || {
            let [least, most] = [SEARCH_DRIVES.start(), SEARCH_DRIVES.end()];
            let allowed = format!("0, or from {least} to {most} drives");
            Mistake::value("evaluation.calibration.search_drives", searched, allowed)
        });
    }

    /// Finds recorded drives that cannot be, or cannot count for a threshold that is not `calibrated`.
    pub(super) fn check_recorded(&self, calibrated: bool, mistakes: &mut Mistakes) {
        let [drives, columns] =
            ["drives", "columns"].map(|key| format!("evaluation.calibration.{key}"));
        mistakes.unless(self.drives.len() <= MOST_RECORDED, || {
            Mistake::value(&drives, self.drives.len(), format!("at most {MOST_RECORDED} files"))
        });
        for (index, file) in self.drives.iter().enumerate() {
            let key = format!("{drives}[{index}]");
            mistakes
                .unless(!file.is_empty(), || Mistake::value(&key, "\"\"", "the path of a file"));
            mistakes.unless(!self.drives[..index].contains(file), || {
                Mistake::value(&key, format_args!("{file:?}"), "each file once")
            });
        }
        mistakes.unless(calibrated || self.drives.is_empty(), || {
            Mistake::value(
                &drives,
                format_args!("{:?}", self.drives),
                "none with this kind of threshold",
            )
            .help("recorded drives count for the thresholds \"adaptive\" and \"calibrated\"")
            .because_of("evaluation.threshold")
        });
        if let Some(file) = &self.columns {
            mistakes.unless(!self.drives.is_empty(), || {
                Mistake::value(&columns, format_args!("{file:?}"), "nothing without `drives`")
                    .help("name the recorded drives whose columns it describes")
            });
        }
    }

    /// Finds what is not possible under so many disturbances and for lateral speeds in a range.
    pub(super) fn check_drives(
        &self,
        disturbances: usize,
        [min, max]: [f64; 2],
        mistakes: &mut Mistakes,
    ) {
        let table = "evaluation.calibration";
        if mistakes.sound(table) && mistakes.sound("disturbance") {
            let drives = self.drives(disturbances);
            mistakes.unless(drives <= MOST_DRIVES, || {
                let allowed = format!("at most {MOST_DRIVES} drives in all");
                Mistake::value(table, format_args!("{drives} drives"), allowed)
                    .help("lower `speeds`, `disturbance_frequencies` or `disturbance_phases`")
            });
        }
        let range = "operating_range.v_y_m_per_s";
        if mistakes.sound(range) {
            let allowed = Allowed::between(min, max);
            let mut speeds = self.initial_v_y_m_per_s.iter().flatten().enumerate();
            if let Some((index, v_y)) = speeds.find(|(_, v_y)| !allowed.holds(**v_y)) {
                let key = format!("{table}.initial_v_y_m_per_s[{index}]");
                mistakes.add(
                    Mistake::value(key, v_y, allowed)
                        .help("set initial lateral speeds within the range")
                        .because_of(range),
                );
            }
        }
    }
}
