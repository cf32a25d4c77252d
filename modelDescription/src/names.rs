//! What the FMUs and their system are called: as models, as libraries and as files.

macro_rules! names {
    ($($(#[$attribute:meta])+ $name:ident, $file:ident: $text:literal, $extension:literal;)+) => {$(
        $(#[$attribute])+
        pub const $name: &str = $text;
        #[doc = concat!("File of [`", stringify!($name), "`].")]
        pub const $file: &str = concat!($text, $extension);
    )+};
}

names! {
    /// The detector.
    DETECTOR, DETECTOR_FILE: "SteeringFaultDetector", ".fmu";
    /// The reference vehicle.
    PLANT, PLANT_FILE: "VehiclePlant", ".fmu";
    /// The detector on the reference vehicle.
    SYSTEM, SYSTEM_FILE: "SteeringFaultSystem", ".ssp";
}

/// The detector's library for FMI 3.0 where it is built; inside the FMU it has the name of that for FMI 2.0.
pub const DETECTOR_FMI3: &str = "SteeringFaultDetectorFmi3";
