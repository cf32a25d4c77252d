//! The variables of `SteeringFaultDetector.fmu`.
//!
//! # Conventions
//! - Axes ISO 8855: x forward, y left, yaw rate counter-clockwise; steering angle at the road wheel.
//! - Outputs and locals hold the results of the last sample run and change in `fmi2DoStep` only.

use crate::names::DETECTOR;
use crate::structure::{Array, MatchingRule, Member, Structure, Terminal, TriggeredClock};
use crate::{Kind, ModelInfo, Role, enumeration, unit, variables};

/// The model as a whole.
pub const INFO: ModelInfo = ModelInfo {
    name: DETECTOR,
    identifier: DETECTOR,
    description: "Detects steering faults from speed, yaw rate, drive torque and steering angle: \
                  a Takagi-Sugeno observer whose residual is held against a threshold.",
};

/// First alarm time before any alarm, s.
pub const NO_ALARM_TIME: f64 = -1.0;

enumeration! {
    /// Items of the output `state`.
    pub enum DetectorState: "DetectorState", "Which condition holds at the last sample" {
        Starting, "No sample yet";
        Monitoring, "Residual, J and alarm are valid";
        OutOfRange, "Outside the range of the design: the residual raises no new alarm";
        InvalidInput, "An input is not finite or beyond its limits: the last results are held";
        Disabled, "Switched off by the input enabled: no alarm, and a clean start afterwards";
        StaleInput, "v_x and r have not changed for stale_after_s: no new alarm";
    }
}

enumeration! {
    /// Items of `state_cause`.
    pub enum DetectorStateCause: "DetectorStateCause", "Which variable or limit holds the state" {
        Nothing, "Monitoring, or no sample yet";
        SpeedX, "v_x is invalid or out of range";
        YawRate, "r is invalid or out of range";
        DriveTorque, "u.T_eng is invalid";
        SteeringAngle, "u.delta is invalid";
        LateralSpeed, "v_y_hat is out of range";
        Unchanged, "v_x and r do not change";
        NotEnabled, "enabled is false";
    }
}

enumeration! {
    /// Items of `alarm_cause`.
    pub enum DetectorAlarmCause: "DetectorAlarmCause", "Which test raised the alarm that stands" {
        NoAlarm, "No alarm stands";
        Residual, "J_rms reached J_th";
        Range, "The vehicle left the range of the design, and no reference motion does";
        SecondTest, "A fault from some sample on is likelier than what is uncertain";
    }
}

enumeration! {
    /// Items of `fault_hypothesis`.
    pub enum DetectorFaultHypothesis: "DetectorFaultHypothesis", "What the fault is, as far as that can be told" {
        NotKnown, "No alarm stands, or the second test has found nothing";
        Steering, "The road wheels are not where they were told to be";
        YawRateSensor, "The sensor of r has stepped, and the steering is likely sound";
        SpeedSensor, "The sensor of v_x has stepped, and the steering is likely sound";
        Undecided, "More than one of these is left";
    }
}

enumeration! {
    /// Items of the parameter `initialisation`.
    pub enum Initialisation: "Initialisation", "How the observer starts at the first sample" {
        FirstMeasurement, "From the first measurement, lateral speed assumed zero";
        Given, "From the parameters z_0[1], z_0[2], z_0[3]";
    }
}

variables! {
    /// The variables of the detector.
    pub enum DetectorVariable {
        // Inputs.
        SpeedX, "v_x", "Measured longitudinal speed at the centre of gravity", Role::INPUT,
            Kind::real(&unit::METRE_PER_SECOND).min(-150.0).max(150.0).nominal(10.0);
        YawRate, "r", "Measured yaw rate, counter-clockwise", Role::INPUT,
            Kind::real(&unit::RADIAN_PER_SECOND).min(-20.0).max(20.0).nominal(0.1);
        DriveTorque, "u.T_eng", "Drive torque at the wheels, negative when braking", Role::INPUT,
            Kind::real(&unit::NEWTON_METRE).min(-1e6).max(1e6).nominal(100.0);
        SteeringAngle, "u.delta", "Commanded steering angle at the road wheel, left positive",
            Role::INPUT, Kind::real(&unit::RADIAN).min(-1.6).max(1.6).nominal(0.02);
        Enabled, "enabled",
            "False while the controller is not engaged, stability control brakes, or the driver steers against it",
            Role::DISCRETE_INPUT, Kind::Boolean;

        // Outputs.
        ResidualSpeedX, "residual.v_x", "Residual of the longitudinal speed", Role::OUTPUT,
            Kind::real(&unit::METRE_PER_SECOND).nominal(0.01);
        ResidualYawRate, "residual.r", "Residual of the yaw rate", Role::OUTPUT,
            Kind::real(&unit::RADIAN_PER_SECOND).nominal(0.001);
        Rms, "J_rms", "Windowed RMS of the weighted residual", Role::OUTPUT,
            Kind::real(&unit::ONE).min(0.0).nominal(0.001);
        Threshold, "J_th", "Threshold that J_rms is held against", Role::OUTPUT,
            Kind::real(&unit::ONE).min(0.0).nominal(0.001);
        Alarm, "alarm", "True from a steering fault's detection until alarm_hold_s after J_rms has sunk", Role::OUTPUT, Kind::Boolean;
        State, "state", "Which condition holds: alarms are given while Monitoring", Role::OUTPUT,
            Kind::Enumeration(&DetectorState::TYPE);
        FaultEstimate, "fault_estimate",
            "Road wheel's angle less the commanded one, where the second test has found a fault; else 0",
            Role::OUTPUT, Kind::real(&unit::RADIAN).nominal(0.01);
        FaultEstimateBound, "fault_estimate_bound", "Largest error of fault_estimate; 0 where there is none",
            Role::OUTPUT, Kind::real(&unit::RADIAN).min(0.0).nominal(0.01);

        // Locals.
        LateralSpeed, "v_y_hat", "Estimated lateral speed, left positive", Role::LOCAL,
            Kind::real(&unit::METRE_PER_SECOND).nominal(0.1);
        Ratio, "J_ratio", "J_rms / J_th", Role::LOCAL, Kind::real(&unit::ONE).min(0.0).nominal(1.0);
        Detectability, "detectability",
            "J that the smallest fault of interest would make alone, had it acted since the observer's start, over J_th",
            Role::LOCAL, Kind::real(&unit::ONE).min(0.0).nominal(1.0);
        Excited, "excited", "Whether the smallest fault of interest could be seen: detectability is 1 or more",
            Role::LOCAL, Kind::Boolean;
        AlarmLatched, "alarm_latched", "True once an alarm was raised, until reset", Role::LOCAL,
            Kind::Boolean;
        FirstAlarmTime, "first_alarm_time",
            "Sample time of the first alarm; -1 while alarm_latched is false", Role::LOCAL,
            Kind::real(&unit::SECOND).nominal(1.0);
        FaultOnsetTime, "fault_onset_time",
            "Sample time from which on fault_estimate acts; -1 where there is none", Role::LOCAL,
            Kind::real(&unit::SECOND).nominal(1.0);
        SecondRatio, "second_ratio", "Statistic of the second test over its threshold", Role::LOCAL,
            Kind::real(&unit::ONE).min(0.0).nominal(1.0);
        AlarmCause, "alarm_cause", "Which test raised the alarm that stands", Role::LOCAL,
            Kind::Enumeration(&DetectorAlarmCause::TYPE);
        FaultHypothesis, "fault_hypothesis",
            "What the fault that the second test has found is, as far as that can be told", Role::LOCAL,
            Kind::Enumeration(&DetectorFaultHypothesis::TYPE);
        StateCause, "state_cause", "Which variable or limit holds the state", Role::LOCAL,
            Kind::Enumeration(&DetectorStateCause::TYPE);
        // For importers that read no enumerations.
        AlarmCauseIndex, "alarm_cause_index", "The value of alarm_cause as an Integer", Role::LOCAL,
            Kind::index_of(&DetectorAlarmCause::TYPE);
        FaultHypothesisIndex, "fault_hypothesis_index", "The value of fault_hypothesis as an Integer",
            Role::LOCAL, Kind::index_of(&DetectorFaultHypothesis::TYPE);
        StateCauseIndex, "state_cause_index", "The value of state_cause as an Integer", Role::LOCAL,
            Kind::index_of(&DetectorStateCause::TYPE);
        StateIndex, "state_index", "The value of state as an Integer", Role::LOCAL,
            Kind::index_of(&DetectorState::TYPE);
        InitialisationIndex, "initialisation_index", "The value of initialisation as an Integer",
            Role::FIXED_LOCAL, Kind::index_of(&Initialisation::TYPE);

        // Parameters.
        ThresholdFactor, "threshold_factor", "Factor on J_th; 1 is the threshold of the design",
            Role::TUNABLE_PARAMETER, Kind::real(&unit::ONE).min(1e-3).max(1e3).nominal(1.0);
        DebounceSamples, "debounce_samples",
            "Consecutive samples with J_rms at or above J_th that raise the alarm",
            Role::TUNABLE_PARAMETER, Kind::Integer { min: 1, max: 1_000_000 };
        AlarmHold, "alarm_hold_s",
            "Time of monitoring with J_rms below 0.8 J_th that ends an alarm",
            Role::TUNABLE_PARAMETER, Kind::real(&unit::SECOND).min(0.0).max(3600.0).nominal(1.0);
        SteeringOffset, "steering_offset",
            "Commanded angle at the road wheel at which the vehicle drives straight ahead: subtracted",
            Role::FIXED_PARAMETER, Kind::real(&unit::RADIAN).min(-0.2).max(0.2).nominal(0.01);
        YawRateBias, "yaw_rate_bias", "Yaw rate shown at standstill: subtracted",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(-0.2).max(0.2).nominal(0.01);
        StaleAfter, "stale_after_s",
            "v_x and r unchanged for longer are stale; 0 for never",
            Role::FIXED_PARAMETER, Kind::real(&unit::SECOND).min(0.0).max(3600.0).nominal(0.1);
        Initialisation, "initialisation", "How the observer starts at the first sample",
            Role::FIXED_PARAMETER, Kind::Enumeration(&Initialisation::TYPE);
        InitialZ1, "z_0[1]", "Observer state z_1 at the first sample, if initialisation is Given",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(-1e3).max(1e3).nominal(10.0);
        InitialZ2, "z_0[2]", "Observer state z_2 at the first sample, if initialisation is Given",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(-1e3).max(1e3).nominal(0.1);
        InitialZ3, "z_0[3]", "Observer state z_3 at the first sample, if initialisation is Given",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(-1e3).max(1e3).nominal(0.1);

        // The design in this binary.
        DesignHash, "design.hash", "SHA-256 of the design file", Role::CONSTANT, Kind::String;
        DesignSamplePeriod, "design.sample_period", "Sampling period T_s of the detector",
            Role::CONSTANT, Kind::real(&unit::SECOND).nominal(0.01);
        DesignCertified, "design.certified",
            "True if beta, gamma and gap are proven; else they are 0", Role::CONSTANT, Kind::Boolean;
        DesignBlind, "design.blind",
            "True if the design misses its smallest fault of interest straight ahead",
            Role::CONSTANT, Kind::Boolean;
        DesignBeta, "design.beta", "Certified fault sensitivity beta of the design", Role::CONSTANT,
            Kind::real(&unit::ONE).nominal(1.0);
        DesignGamma, "design.gamma", "Certified disturbance gain gamma of the design",
            Role::CONSTANT, Kind::real(&unit::ONE).nominal(0.01);
        DesignGap, "design.gap", "Certified fault-to-disturbance gap of the design",
            Role::CONSTANT, Kind::real(&unit::ONE).nominal(1.0);
        DesignThreshold, "design.threshold",
            "J_th after the start-up, where nothing is uncertain, for threshold_factor = 1",
            Role::CONSTANT, Kind::real(&unit::ONE).nominal(0.001);
        DesignUncertaintyShare, "design.uncertainty_share",
            "Share of the uncertainties' bound on J that is added to J_th",
            Role::CONSTANT, Kind::real(&unit::ONE).min(0.0).nominal(1.0);
        DesignWindow, "design.window", "Samples in the window of J_rms", Role::CONSTANT,
            Kind::Integer { min: 1, max: i32::MAX };
        DesignWeightSpeedX, "design.weight.v_x", "Weight of residual.v_x in J_rms, per m/s",
            Role::CONSTANT, Kind::real(&unit::ONE).nominal(1.0);
        DesignWeightYawRate, "design.weight.r", "Weight of residual.r in J_rms, per rad/s",
            Role::CONSTANT, Kind::real(&unit::ONE).nominal(1.0);
        RangeSpeedXMin, "design.range.v_x_min", "Lowest longitudinal speed of the design range",
            Role::CONSTANT, Kind::real(&unit::METRE_PER_SECOND).nominal(10.0);
        RangeSpeedXMax, "design.range.v_x_max", "Highest longitudinal speed of the design range",
            Role::CONSTANT, Kind::real(&unit::METRE_PER_SECOND).nominal(10.0);
        RangeSpeedYMin, "design.range.v_y_min", "Lowest lateral speed of the design range",
            Role::CONSTANT, Kind::real(&unit::METRE_PER_SECOND).nominal(1.0);
        RangeSpeedYMax, "design.range.v_y_max", "Highest lateral speed of the design range",
            Role::CONSTANT, Kind::real(&unit::METRE_PER_SECOND).nominal(1.0);
        RangeYawRateMin, "design.range.r_min", "Lowest yaw rate of the design range",
            Role::CONSTANT, Kind::real(&unit::RADIAN_PER_SECOND).nominal(0.5);
        RangeYawRateMax, "design.range.r_max", "Highest yaw rate of the design range",
            Role::CONSTANT, Kind::real(&unit::RADIAN_PER_SECOND).nominal(0.5);

        // The actuator between u.delta and the road wheel: the names of the reference vehicle, behind
        // `design.`.
        ActuatorLag, "design.actuator.lag", "Time constant of the steering actuator, 0 for none",
            Role::CONSTANT, Kind::real(&unit::SECOND).nominal(0.1);
        ActuatorDelay, "design.actuator.delay", "Dead time of the steering actuator, 0 for none",
            Role::CONSTANT, Kind::real(&unit::SECOND).nominal(0.1);
        ActuatorRateLimit, "design.actuator.rate_limit",
            "Fastest turn of the road wheel by the actuator, 0 for no limit",
            Role::CONSTANT, Kind::real(&unit::RADIAN_PER_SECOND).nominal(1.0);
        ActuatorAngleLimit, "design.actuator.angle_limit",
            "Largest angle of the road wheel by the actuator, 0 for no limit",
            Role::CONSTANT, Kind::real(&unit::RADIAN).nominal(1.0);

        // The vehicle it was designed for.
        VehicleMass, "vehicle.M_v", "Vehicle mass", Role::CONSTANT,
            Kind::real(&unit::KILOGRAM).nominal(1e3);
        VehicleYawInertia, "vehicle.I_z", "Yaw moment of inertia", Role::CONSTANT,
            Kind::real(&unit::KILOGRAM_METRE_SQUARED).nominal(1e3);
        VehicleLongitudinalInertia, "vehicle.I_e",
            "Effective longitudinal inertia: drive torque per longitudinal acceleration",
            Role::CONSTANT, Kind::real(&unit::KILOGRAM_METRE).nominal(1e3);
        VehicleFrontAxleDistance, "vehicle.l_f", "Distance from centre of gravity to front axle",
            Role::CONSTANT, Kind::real(&unit::METRE).nominal(1.0);
        VehicleRearAxleDistance, "vehicle.l_r", "Distance from centre of gravity to rear axle",
            Role::CONSTANT, Kind::real(&unit::METRE).nominal(1.0);
        VehicleFrontStiffness, "vehicle.C_f", "Cornering stiffness of one front tyre",
            Role::CONSTANT, Kind::real(&unit::NEWTON_PER_RADIAN).nominal(1e5);
        VehicleRearStiffness, "vehicle.C_r", "Cornering stiffness of one rear tyre",
            Role::CONSTANT, Kind::real(&unit::NEWTON_PER_RADIAN).nominal(1e5);
        VehicleLongitudinalDrag, "vehicle.C_x", "Longitudinal drag: wheel torque per speed squared",
            Role::CONSTANT,
            Kind::real(&unit::NEWTON_METRE_SECOND_SQUARED_PER_METRE_SQUARED).nominal(1.0);
        VehicleLateralDrag, "vehicle.C_y", "Lateral drag: force per lateral speed squared",
            Role::CONSTANT, Kind::real(&unit::NEWTON_SECOND_SQUARED_PER_METRE_SQUARED).nominal(1.0);
        VehicleHeight, "vehicle.h", "Height of the centre of gravity, 0 for no transfer of axle load",
            Role::CONSTANT, Kind::real(&unit::METRE).nominal(1.0);
    }
}

impl Structure for DetectorVariable {
    const ARRAYS: &'static [Array<Self>] = &[
        Array {
            name: "residual",
            description: "Residual: of the longitudinal speed, m/s, and of the yaw rate, rad/s",
            elements: &[Self::ResidualSpeedX, Self::ResidualYawRate],
        },
        Array {
            name: "z_0",
            description: "Observer state z at the first sample, m/s, m/s, rad/s, if initialisation is Given",
            elements: &[Self::InitialZ1, Self::InitialZ2, Self::InitialZ3],
        },
    ];
    const CLOCK: TriggeredClock<Self> = TriggeredClock {
        watched: Self::Alarm,
        name: "alarm_change",
        description: "Ticks at the sample that raises or ends the alarm",
        time_name: "alarm_change_time",
        time_description: "Sample time of the last tick of alarm_change; -1 before the first",
    };
    const TERMINALS: &'static [Terminal<Self>] = &[
        Terminal {
            name: "measurement",
            description: "What the vehicle measures",
            matching_rule: MatchingRule::Plug,
            members: &[
                ("v_x", Member::Variable(Self::SpeedX)),
                ("r", Member::Variable(Self::YawRate)),
            ],
        },
        Terminal {
            name: "command",
            description: "What the driver or the controller commands",
            matching_rule: MatchingRule::Plug,
            members: &[
                ("T_eng", Member::Variable(Self::DriveTorque)),
                ("delta", Member::Variable(Self::SteeringAngle)),
            ],
        },
        Terminal {
            name: "verdict",
            description: "What the detector says",
            matching_rule: MatchingRule::Bus,
            members: &[
                ("alarm", Member::Variable(Self::Alarm)),
                ("state", Member::Variable(Self::State)),
                ("residual", Member::Array(0)),
                ("J_rms", Member::Variable(Self::Rms)),
                ("J_th", Member::Variable(Self::Threshold)),
                ("fault_estimate", Member::Variable(Self::FaultEstimate)),
                ("fault_estimate_bound", Member::Variable(Self::FaultEstimateBound)),
                ("alarm_change", Member::Clock),
                ("alarm_change_time", Member::ClockTime),
            ],
        },
    ];
}
