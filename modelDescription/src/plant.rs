//! The variables of `VehiclePlant.fmu`.
//!
//! # Conventions
//! - Axes ISO 8855: x forward, y left, yaw rate counter-clockwise; angles at the road wheel.
//! - `vehicle.*` have the names that the detector gives its vehicle data, so that an importer can
//!   copy them from one FMU to the other.

use crate::names::PLANT;
use crate::{Causality, Initial, Kind, ModelInfo, Role, Variability, unit, variables};

/// The model as a whole.
pub const INFO: ModelInfo = ModelInfo {
    name: PLANT,
    identifier: PLANT,
    description: "Reference vehicle for the steering-fault detector: nonlinear two-degree-of-freedom \
                  dynamics with longitudinal speed, steering fault, disturbances and sensor errors.",
};

/// A signal that moves during a communication step.
const SIGNAL: Role = Role {
    causality: Causality::Output,
    variability: Variability::Continuous,
    initial: Some(Initial::Calculated),
};

variables! {
    /// The variables of the plant.
    pub enum PlantVariable {
        // Inputs, held over a communication step.
        DriveTorque, "u.T_eng", "Drive torque at the wheels, negative when braking", Role::INPUT,
            Kind::real(&unit::NEWTON_METRE).min(-1e6).max(1e6).nominal(100.0);
        SteeringAngle, "u.delta", "Commanded steering angle at the road wheel, left positive",
            Role::INPUT, Kind::real(&unit::RADIAN).min(-1.6).max(1.6).nominal(0.02);
        Fault, "fault", "Steering fault: added to the angle of the actuator", Role::INPUT,
            Kind::real(&unit::RADIAN).min(-1.6).max(1.6).nominal(0.01);
        SideForce, "disturbance.side_force", "Lateral force at the centre of gravity, left positive",
            Role::INPUT, Kind::real(&unit::NEWTON).min(-1e6).max(1e6).nominal(100.0);
        YawMoment, "disturbance.yaw_moment", "Yaw moment on the vehicle, counter-clockwise",
            Role::INPUT, Kind::real(&unit::NEWTON_METRE).min(-1e6).max(1e6).nominal(100.0);

        // Outputs.
        SpeedX, "v_x", "Measured longitudinal speed, with the errors of its sensor", SIGNAL,
            Kind::real(&unit::METRE_PER_SECOND).nominal(10.0);
        YawRate, "r", "Measured yaw rate, with the errors of its sensor", SIGNAL,
            Kind::real(&unit::RADIAN_PER_SECOND).nominal(0.1);
        TrueSpeedX, "true.v_x", "Longitudinal speed of the centre of gravity", SIGNAL,
            Kind::real(&unit::METRE_PER_SECOND).nominal(10.0);
        TrueSpeedY, "true.v_y", "Lateral speed of the centre of gravity", SIGNAL,
            Kind::real(&unit::METRE_PER_SECOND).nominal(0.1);
        TrueYawRate, "true.r", "Yaw rate", SIGNAL,
            Kind::real(&unit::RADIAN_PER_SECOND).nominal(0.1);
        WheelAngle, "true.delta", "Steering angle of the road wheel, fault included", SIGNAL,
            Kind::real(&unit::RADIAN).nominal(0.02);

        // Initial state.
        InitialSpeedX, "initial.v_x", "Longitudinal speed at the start", Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(0.0).max(150.0).nominal(10.0);
        InitialSpeedY, "initial.v_y", "Lateral speed at the start", Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(-50.0).max(50.0).nominal(1.0);
        InitialYawRate, "initial.r", "Yaw rate at the start", Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(-20.0).max(20.0).nominal(0.1);

        // Vehicle.
        Mass, "vehicle.M_v", "Vehicle mass", Role::FIXED_PARAMETER,
            Kind::real(&unit::KILOGRAM).min(1.0).max(1e6).nominal(1e3);
        YawInertia, "vehicle.I_z", "Yaw moment of inertia", Role::FIXED_PARAMETER,
            Kind::real(&unit::KILOGRAM_METRE_SQUARED).min(1.0).max(1e8).nominal(1e3);
        LongitudinalInertia, "vehicle.I_e",
            "Effective longitudinal inertia: drive torque per longitudinal acceleration",
            Role::FIXED_PARAMETER, Kind::real(&unit::KILOGRAM_METRE).min(0.1).max(1e6).nominal(1e3);
        FrontAxleDistance, "vehicle.l_f", "Distance from centre of gravity to front axle",
            Role::FIXED_PARAMETER, Kind::real(&unit::METRE).min(0.01).max(50.0).nominal(1.0);
        RearAxleDistance, "vehicle.l_r", "Distance from centre of gravity to rear axle",
            Role::FIXED_PARAMETER, Kind::real(&unit::METRE).min(0.01).max(50.0).nominal(1.0);
        FrontStiffness, "vehicle.C_f", "Cornering stiffness of one front tyre",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::NEWTON_PER_RADIAN).min(1.0).max(1e8).nominal(1e5);
        RearStiffness, "vehicle.C_r", "Cornering stiffness of one rear tyre",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::NEWTON_PER_RADIAN).min(1.0).max(1e8).nominal(1e5);
        LongitudinalDrag, "vehicle.C_x", "Longitudinal drag: wheel torque per speed squared",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::NEWTON_METRE_SECOND_SQUARED_PER_METRE_SQUARED)
                .min(0.0).max(1e4).nominal(1.0);
        LateralDrag, "vehicle.C_y", "Lateral drag: force per lateral speed squared",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::NEWTON_SECOND_SQUARED_PER_METRE_SQUARED)
                .min(0.0).max(1e4).nominal(1.0);
        CentreOfGravityHeight, "vehicle.h",
            "Height of the centre of gravity above the road, 0 for no load transfer",
            Role::FIXED_PARAMETER, Kind::real(&unit::METRE).min(0.0).max(10.0).nominal(0.5);

        // What the detector does not know.
        FrictionLimited, "tyre.friction_limited", "Whether friction limits the axle forces (tanh)",
            Role::FIXED_PARAMETER, Kind::Boolean;
        Friction, "tyre.friction", "Friction coefficient, used if tyre.friction_limited",
            Role::FIXED_PARAMETER, Kind::real(&unit::ONE).min(0.01).max(10.0).nominal(1.0);
        ActuatorLag, "actuator.lag",
            "Time constant of the steering actuator, 0 for none",
            Role::FIXED_PARAMETER, Kind::real(&unit::SECOND).min(0.0).max(10.0).nominal(0.1);
        ActuatorDelay, "actuator.delay",
            "Dead time of the steering actuator in whole milliseconds, 0 for none",
            Role::FIXED_PARAMETER, Kind::real(&unit::SECOND).min(0.0).max(1.5).nominal(0.1);
        ActuatorRateLimit, "actuator.rate_limit",
            "Fastest turn of the road wheel by the steering actuator, 0 for no limit",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(0.0).max(100.0).nominal(1.0);
        ActuatorAngleLimit, "actuator.angle_limit",
            "Largest angle of the road wheel to either side by the steering actuator, 0 for no limit",
            Role::FIXED_PARAMETER, Kind::real(&unit::RADIAN).min(0.0).max(1.6).nominal(0.5);
        SteeringRatio, "steering.ratio",
            "Angle of the road wheel per commanded angle: 1 where the steering ratio is right",
            Role::FIXED_PARAMETER, Kind::real(&unit::ONE).min(0.1).max(10.0).nominal(1.0);
        SteeringOffset, "steering.offset",
            "What the steering shows at zero: the road wheel stands this far to the right of u.delta",
            Role::FIXED_PARAMETER, Kind::real(&unit::RADIAN).min(-0.2).max(0.2).nominal(0.005);
        Bank, "road.bank",
            "Road bank, positive with the left side raised: gravity then pulls to the right",
            Role::FIXED_PARAMETER, Kind::real(&unit::RADIAN).min(-1.0).max(1.0).nominal(0.05);
        BiasSpeedX, "sensor.v_x_bias", "What the sensor of v_x shows at zero",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(-10.0).max(10.0).nominal(0.05);
        BiasYawRate, "sensor.r_bias", "What the sensor of r shows at zero",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(-1.0).max(1.0).nominal(0.002);
        ScaleSpeedX, "sensor.v_x_scale", "Relative error of the scale of v_x",
            Role::FIXED_PARAMETER, Kind::real(&unit::ONE).min(-0.5).max(0.5).nominal(0.01);
        ScaleYawRate, "sensor.r_scale", "Relative error of the scale of r",
            Role::FIXED_PARAMETER, Kind::real(&unit::ONE).min(-0.5).max(0.5).nominal(0.01);
        ResolutionSpeedX, "sensor.v_x_resolution",
            "Distance between the values that v_x can take, 0 for any", Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(0.0).max(10.0).nominal(0.01);
        ResolutionYawRate, "sensor.r_resolution",
            "Distance between the values that r can take, 0 for any", Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(0.0).max(1.0).nominal(0.001);
        SensorsHeld, "sensor.held",
            "Whether v_x and r are held for noise.sample_period, as the noise on them always is",
            Role::FIXED_PARAMETER, Kind::Boolean;
        NoiseSpeedX, "noise.v_x", "Standard deviation of the white noise on v_x",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::METRE_PER_SECOND).min(0.0).max(10.0).nominal(0.02);
        NoiseYawRate, "noise.r", "Standard deviation of the white noise on r",
            Role::FIXED_PARAMETER,
            Kind::real(&unit::RADIAN_PER_SECOND).min(0.0).max(10.0).nominal(0.002);
        NoisePeriod, "noise.sample_period", "Time for which a value of the noise is held",
            Role::FIXED_PARAMETER, Kind::real(&unit::SECOND).min(1e-4).max(10.0).nominal(0.01);
        NoiseSeed, "noise.seed", "Seed of the noise: same seed, same noise",
            Role::FIXED_PARAMETER, Kind::Integer { min: i32::MIN, max: i32::MAX };
    }
    dependencies {
        SpeedX: [], [InitialSpeedX, BiasSpeedX, ScaleSpeedX, ResolutionSpeedX, NoiseSpeedX, NoiseSeed];
        YawRate: [],
            [InitialYawRate, BiasYawRate, ScaleYawRate, ResolutionYawRate, NoiseYawRate, NoiseSeed];
        TrueSpeedX: [], [InitialSpeedX];
        TrueSpeedY: [], [InitialSpeedY];
        TrueYawRate: [], [InitialYawRate];
        WheelAngle: [Fault], [SteeringAngle, Fault, ActuatorAngleLimit, SteeringOffset];
    }
}
