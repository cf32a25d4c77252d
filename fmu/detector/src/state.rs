//! How the detector's conditions and causes appear as items of enumerations.

use steerguard_detector::{
    AlarmCause, FaultEstimate, FaultHypothesis, Monitor, Signal, StateCause,
};
use steerguard_model_description::detector::{
    DetectorAlarmCause, DetectorFaultHypothesis, DetectorState, DetectorStateCause,
};

/// The item of `state` while a condition holds.
pub const fn state(monitor: Monitor) -> DetectorState {
    match monitor {
        Monitor::Starting => DetectorState::Starting,
        Monitor::Monitoring => DetectorState::Monitoring,
        Monitor::OutOfRange => DetectorState::OutOfRange,
        Monitor::InvalidInput => DetectorState::InvalidInput,
        Monitor::Disabled => DetectorState::Disabled,
        Monitor::StaleInput => DetectorState::StaleInput,
    }
}

/// The item of `state_cause` for what keeps the detector from monitoring.
pub const fn state_cause(cause: StateCause) -> DetectorStateCause {
    match cause {
        StateCause::None => DetectorStateCause::Nothing,
        StateCause::Signal(Signal::Speed) => DetectorStateCause::SpeedX,
        StateCause::Signal(Signal::YawRate) => DetectorStateCause::YawRate,
        StateCause::Signal(Signal::DriveTorque) => DetectorStateCause::DriveTorque,
        StateCause::Signal(Signal::SteeringAngle) => DetectorStateCause::SteeringAngle,
        StateCause::LateralSpeed => DetectorStateCause::LateralSpeed,
        StateCause::Unchanged => DetectorStateCause::Unchanged,
        StateCause::NotEnabled => DetectorStateCause::NotEnabled,
    }
}

/// The item of `alarm_cause` for the test that raised the alarm.
pub const fn alarm_cause(cause: AlarmCause) -> DetectorAlarmCause {
    match cause {
        AlarmCause::None => DetectorAlarmCause::NoAlarm,
        AlarmCause::Residual => DetectorAlarmCause::Residual,
        AlarmCause::Range => DetectorAlarmCause::Range,
        AlarmCause::SecondTest => DetectorAlarmCause::SecondTest,
    }
}

/// The item of `fault_hypothesis` for what the second test knows.
pub const fn fault_hypothesis(estimate: Option<&FaultEstimate>) -> DetectorFaultHypothesis {
    let Some(FaultEstimate { hypothesis, .. }) = estimate else {
        return DetectorFaultHypothesis::NotKnown;
    };
    match hypothesis {
        FaultHypothesis::Undecided => DetectorFaultHypothesis::Undecided,
        FaultHypothesis::Steering => DetectorFaultHypothesis::Steering,
        FaultHypothesis::YawRateSensor => DetectorFaultHypothesis::YawRateSensor,
        FaultHypothesis::SpeedSensor => DetectorFaultHypothesis::SpeedSensor,
    }
}
