//! The units in use, with their base exponents and the units in which a graphical importer shows
//! them.

/// A unit in which values are exchanged: coherent SI, so that factor 1 and offset 0 lead to the
/// base units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name as it appears in the description, such as `m/s`.
    pub name: &'static str,
    /// Exponents of kg, m, s and rad.
    pub base: [i8; 4],
    /// Units for display, the preferred one first.
    pub display: &'static [DisplayUnit],
}

/// A unit for display: value in it = `factor` x value in the [`Unit`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplayUnit {
    /// Name as it appears in the description, such as `km/h`.
    pub name: &'static str,
    /// Display units per unit.
    pub factor: f64,
}

#[cfg(feature = "xml")]
/// Base units in the order of [`Unit::base`].
pub const BASE_UNITS: [&str; 4] = ["kg", "m", "s", "rad"];

const DEGREES_PER_RADIAN: f64 = 180.0 / core::f64::consts::PI;

const fn unit(name: &'static str, base: [i8; 4], display: &'static [DisplayUnit]) -> Unit {
    Unit { name, base, display }
}

const fn display(name: &'static str, factor: f64) -> DisplayUnit {
    DisplayUnit { name, factor }
}

/// Dimensionless.
pub const ONE: Unit = unit("1", [0, 0, 0, 0], &[]);
/// Speed, displayed in km/h.
pub const METRE_PER_SECOND: Unit = unit("m/s", [0, 1, -1, 0], &[display("km/h", 3.6)]);
/// Specific force or acceleration.
pub const METRE_PER_SECOND_SQUARED: Unit = unit("m/s2", [0, 1, -2, 0], &[]);
/// Angle, displayed in degrees.
pub const RADIAN: Unit = unit("rad", [0, 0, 0, 1], &[display("deg", DEGREES_PER_RADIAN)]);
/// Angular rate, displayed in degrees per second.
pub const RADIAN_PER_SECOND: Unit =
    unit("rad/s", [0, 0, -1, 1], &[display("deg/s", DEGREES_PER_RADIAN)]);
/// Angular acceleration, displayed in degrees per second squared.
pub const RADIAN_PER_SECOND_SQUARED: Unit =
    unit("rad/s2", [0, 0, -2, 1], &[display("deg/s2", DEGREES_PER_RADIAN)]);
/// Torque.
pub const NEWTON_METRE: Unit = unit("N.m", [1, 2, -2, 0], &[]);
/// Force, displayed in kN.
pub const NEWTON: Unit = unit("N", [1, 1, -2, 0], &[display("kN", 1e-3)]);
/// Time, displayed in ms.
pub const SECOND: Unit = unit("s", [0, 0, 1, 0], &[display("ms", 1e3)]);
/// Frequency.
pub const HERTZ: Unit = unit("Hz", [0, 0, -1, 0], &[]);
/// Mass.
pub const KILOGRAM: Unit = unit("kg", [1, 0, 0, 0], &[]);
/// Length.
pub const METRE: Unit = unit("m", [0, 1, 0, 0], &[]);
/// Mass times length: the effective longitudinal inertia, torque per acceleration.
pub const KILOGRAM_METRE: Unit = unit("kg.m", [1, 1, 0, 0], &[]);
/// Moment of inertia.
pub const KILOGRAM_METRE_SQUARED: Unit = unit("kg.m2", [1, 2, 0, 0], &[]);
/// Cornering stiffness, displayed in N/deg.
pub const NEWTON_PER_RADIAN: Unit =
    unit("N/rad", [1, 1, -2, -1], &[display("N/deg", 1.0 / DEGREES_PER_RADIAN)]);
/// Torque per speed squared.
pub const NEWTON_METRE_SECOND_SQUARED_PER_METRE_SQUARED: Unit =
    unit("N.m.s2/m2", [1, 0, 0, 0], &[]);
/// Force per speed squared.
pub const NEWTON_SECOND_SQUARED_PER_METRE_SQUARED: Unit = unit("N.s2/m2", [1, -1, 0, 0], &[]);
