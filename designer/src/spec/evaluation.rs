//! `[evaluation]`: how the residual is evaluated.

use serde::{Deserialize, Serialize};
use steerguard_detector::MAX_WINDOW;

use super::Calibration;
use crate::document::{Allowed, Mistake, Mistakes};

/// Window of the RMS where none is stated, s.
const DEFAULT_WINDOW_S: f64 = 0.4;

/// Weights other than 0.
const WEIGHTS: [f64; 2] = [1e-6, 1e6];
/// Most samples of a debounce.
const MOST_DEBOUNCE: u32 = 1000;
/// Thresholds that are neither always nor never reached.
const CONSTANT: Allowed = Allowed::between(1e-9, 1e3);

fn in_samples(window_s: f64, period_s: f64) -> usize {
    (window_s / period_s).round() as usize
}

/// `[evaluation]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Evaluation {
    /// Window of the RMS; default 0.4, or the 256 samples that it may hold at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_s: Option<f64>,
    /// The same in samples, in place of `window_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_samples: Option<usize>,
    /// Diagonal of W_r for the residuals of v_x (per m/s) and r (per rad/s); default [0.1, 1], the
    /// inverse proportion of their noise.
    pub weights: [f64; 2],
    /// How the threshold is found; default "adaptive".
    pub threshold: ThresholdKind,
    /// Threshold of kind "constant", on J once the start-up has passed; for no other kind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub constant: Option<f64>,
    /// Threshold over the level: of kinds "calibrated" and "adaptive" the largest of the calibration's
    /// drives; of kind "guaranteed" the proven bound plus the simulated discretisation, so that it
    /// stands for what neither holds, such as other vehicle data; default 1.1.
    pub margin: f64,
    /// What the threshold of kind "adaptive" stays above; default "random_drives".
    pub covers: Covers,
    /// Consecutive samples above the threshold that raise the alarm; default 1.
    pub debounce_samples: u32,
    /// Time of monitoring with J well below the threshold that ends an alarm; default 1.
    pub alarm_hold_s: f64,
    /// The fault-free drives of the calibration.
    pub calibration: Calibration,
}

impl Default for Evaluation {
    fn default() -> Self {
        Self {
            window_s: None,
            window_samples: None,
            weights: [0.1, 1.0],
            threshold: ThresholdKind::Adaptive,
            constant: None,
            margin: 1.1,
            covers: Covers::RandomDrives,
            debounce_samples: 1,
            alarm_hold_s: 1.0,
            calibration: Calibration::default(),
        }
    }
}

/// How the threshold is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ThresholdKind {
    /// A given number.
    Constant,
    /// Largest level of simulated fault-free drives of the vehicle as specified, times a margin.
    Calibrated,
    /// That level and, sample by sample, the bound on what the uncertainties can do in the manoeuvre
    /// driven; both times the largest ratio of J to their sum over simulated fault-free drives of
    /// uncertain vehicles, times a margin.
    Adaptive,
    /// A proven bound on J for all disturbances and sensor noise within their bounds, plus the
    /// largest level of simulated drives without either, times a margin. White noise has no bound: a
    /// sensor with a white standard deviation must be given a bound too, which then is what counts.
    Guaranteed,
}

/// What a threshold stays above, with its margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Covers {
    /// The calibration's drives, of vehicles drawn at random.
    RandomDrives,
    /// What a short search for the worst drive finds too.
    WorstCase,
}

impl Evaluation {
    /// Finds what is not possible by itself.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        self.check_window(mistakes);
        let weights = self.weights;
        let [least, most] = WEIGHTS;
        let proper = weights.iter().all(|&w| w == 0.0 || (least..=most).contains(&w));
        mistakes.unless(proper && weights != [0.0, 0.0], || {
            let allowed = format!("each 0 or from {least} to {most}, and not both 0");
            Mistake::value("evaluation.weights", weights, allowed)
        });
        mistakes.number("evaluation.margin", self.margin, Allowed::between(1.0, 100.0));
        if mistakes.sound("evaluation.threshold") {
            self.check_constant(mistakes);
        }
        let debounce = self.debounce_samples;
        mistakes.unless((1..=MOST_DEBOUNCE).contains(&debounce), || {
            let allowed = format!("from 1 to {MOST_DEBOUNCE}");
            Mistake::value("evaluation.debounce_samples", debounce, allowed)
                .help("an alarm that waits longer comes too late for any use")
        });
        let hold_s = Allowed::between(0.0, 3600.0);
        mistakes.number("evaluation.alarm_hold_s", self.alarm_hold_s, hold_s);
        self.calibration.check(mistakes);
        if mistakes.sound("evaluation.threshold") {
            let kinds = [ThresholdKind::Calibrated, ThresholdKind::Adaptive];
            self.calibration.check_recorded(kinds.contains(&self.threshold), mistakes);
        }
        self.check_covers(mistakes);
    }

    /// Finds a worst case that is to be covered and is not searched.
    fn check_covers(&self, mistakes: &mut Mistakes) {
        let [key, drives] = ["evaluation.covers", "evaluation.calibration.search_drives"];
        if self.covers == Covers::WorstCase
            && [key, drives].into_iter().all(|key| mistakes.sound(key))
        {
            let adaptive = self.threshold == ThresholdKind::Adaptive;
            mistakes.unless(adaptive, || {
                Mistake::value(key, "worst_case", "\"random_drives\"")
                    .help("only the threshold \"adaptive\" can cover what a search finds")
                    .because_of("evaluation.threshold")
            });
            mistakes.unless(!adaptive || self.calibration.search_drives > 0, || {
                Mistake::value(key, "worst_case", "\"random_drives\" where nothing is searched")
                    .help("give the search drives, 500 for instance")
                    .because_of(drives)
            });
        }
    }

    fn check_window(&self, mistakes: &mut Mistakes) {
        if let Some(window) = self.window_samples {
            let key = "evaluation.window_samples";
            mistakes.unless((1..=MAX_WINDOW).contains(&window), || {
                Mistake::value(key, window, format!("from 1 to {MAX_WINDOW}"))
            });
            mistakes.unless(self.window_s.is_none(), || {
                Mistake::value(key, window, "nothing beside `window_s`")
                    .help("state one of the two")
                    .because_of("evaluation.window_s")
            });
        }
        if let Some(window_s) = self.window_s {
            mistakes.number("evaluation.window_s", window_s, Allowed::POSITIVE);
        }
    }

    /// Finds a stated window that the detector cannot hold.
    pub(super) fn check_window_of(&self, period_s: f64, mistakes: &mut Mistakes) {
        let Some(window_s) = self.window_s else { return };
        let most_s = MAX_WINDOW as f64 * period_s;
        let possible = (1..=MAX_WINDOW).contains(&in_samples(window_s, period_s));
        let key = "evaluation.window_s";
        if mistakes.sound(key) {
            mistakes.unless(possible, || {
                let allowed = format!("from {period_s} to {most_s}, 1 to {MAX_WINDOW} samples");
                Mistake::value(key, window_s, allowed).because_of("sampling.period_s")
            });
        }
    }

    /// The window of the RMS in samples of `period_s`.
    pub fn window(&self, period_s: f64) -> usize {
        self.window_samples.unwrap_or_else(|| {
            in_samples(self.window_s.unwrap_or(DEFAULT_WINDOW_S), period_s).clamp(1, MAX_WINDOW)
        })
    }

    fn check_constant(&self, mistakes: &mut Mistakes) {
        let (threshold, key) = ("evaluation.threshold", "evaluation.constant");
        match (self.threshold, self.constant) {
            (ThresholdKind::Constant, Some(constant)) => {
                mistakes.number(key, constant, CONSTANT);
            }
            (ThresholdKind::Constant, None) => mistakes.add(
                Mistake::missing(key)
                    .help("state the threshold on J, or take another kind")
                    .because_of(threshold),
            ),
            (_, Some(constant)) => mistakes.add(
                Mistake::value(key, constant, "nothing, unless threshold = \"constant\"")
                    .help("remove it, or set threshold = \"constant\"")
                    .because_of(threshold),
            ),
            (_, None) => {}
        }
    }
}
