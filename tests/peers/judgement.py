"""What a detector's statistic is worth: thresholds at a rate of false alarms, detections, delays.

Conventions
- A statistic, T x D (samples, drives), raises the alarm where it reaches the threshold while the
  detectors are armed. All share one arming rule: steerguard's `state` is Monitoring.
- Faults are exposed, masked, detected and missed, delays counted and sizes surely detected exactly
  as `steerguard campaign` does: packaging/src/campaign/outcome.rs and report.rs.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import beta

CONFIDENCE = 0.95
SURE = 0.99
FEWEST = 299  # 0.99^299 < 0.05
RELEASE = 0.8  # of the threshold: below it an alarm may end


def peaks(statistic, armed):
    """Largest value of each drive while armed; 0 if never."""
    return np.where(armed, statistic, 0.0).max(axis=0)


def threshold(peaks, drives_with_alarm):
    """Just above the peaks of all fault-free drives but `drives_with_alarm`."""
    return np.nextafter(np.sort(peaks)[::-1][drives_with_alarm], np.inf)


def alarms(statistic, armed, threshold, period_s, hold_s):
    """Raised where the statistic reaches the threshold; over after `hold_s` armed below RELEASE of it."""
    raises, clear = armed & (statistic >= threshold), armed & (statistic < RELEASE * threshold)
    alarm = np.zeros_like(raises)
    stands, count = np.zeros(raises.shape[1], dtype=bool), np.zeros(raises.shape[1], dtype=int)
    for k in range(len(raises)):
        count = np.where(stands & clear[k], count + 1, 0)
        ends = stands & clear[k] & (count * period_s >= hold_s)
        stands = (stands & ~ends) | (~stands & raises[k])
        alarm[k] = stands
    return alarm


@dataclass
class Outcomes:
    """Of faulty drives, arrays of length D."""

    false_alarm: np.ndarray  # before the fault acted
    exposed: np.ndarray
    masked: np.ndarray
    detected: np.ndarray
    delay_s: np.ndarray  # from exposure; infinite where not detected
    size_deg: np.ndarray  # largest angle that the fault added while armed

    @classmethod
    def of(cls, statistic, armed, fault_rad, threshold, period_s, hold_s=None):
        samples = np.arange(len(armed))[:, None]
        acts = np.logical_or.accumulate(fault_rad != 0, axis=0)
        alarm = armed & (statistic >= threshold)
        if hold_s is not None:
            alarm = alarms(statistic, armed, threshold, period_s, hold_s)
        before = np.vstack([np.zeros((1, alarm.shape[1]), dtype=bool), alarm[:-1]])
        begins = alarm & ~before
        shown = acts & armed
        exposed, exposure = shown.any(axis=0), shown.argmax(axis=0)
        masked = exposed & (alarm & before)[exposure, np.arange(len(exposure))]
        detects = begins & exposed & ~masked & (samples >= exposure)
        detected = detects.any(axis=0)
        delay = np.where(detected, (detects.argmax(axis=0) - exposure) * period_s, np.inf)
        size = np.degrees(np.where(shown, np.abs(fault_rad), 0.0).max(axis=0))
        return cls((begins & ~acts).any(axis=0), exposed, masked, detected, delay, size)

    @classmethod
    def joined(cls, parts):
        """Those of several groups of drives."""
        return cls(
            *map(np.concatenate, zip(*[vars(part).values() for part in parts], strict=True))
        )

    @property
    def tried(self):
        """Faults that can be detected or missed."""
        return self.exposed & ~self.masked

    def delay_quantile_s(self, share):
        """The smallest delay that at least `share` of the faults do not exceed."""
        delays = np.sort(self.delay_s[self.tried])
        return delays[max(1, int(np.ceil(share * len(delays)))) - 1] if len(delays) else np.nan

    def surely_detected_deg(self):
        """The smallest size surely detected; NaN if there is none."""
        order = np.argsort(self.size_deg[self.tried])
        sizes, missed = self.size_deg[self.tried][order], ~self.detected[self.tried][order]
        together = max(FEWEST, len(sizes) // 4)
        smallest = np.nan
        for first in range(len(sizes) - together, -1, -1):
            hits = together - missed[first : first + together].sum()
            if hits == 0 or beta.ppf(1 - CONFIDENCE, hits, together - hits + 1) < SURE:
                break
            smallest = sizes[first]
        return smallest

    def largest_missed_deg(self):
        """NaN if none was missed."""
        missed = self.size_deg[self.tried & ~self.detected]
        return missed.max() if len(missed) else np.nan
