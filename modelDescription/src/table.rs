//! What a variable is: the terms of FMI 2.0.4, section 2.2.7, as constant data.

use core::ffi::CStr;

use crate::unit::Unit;

/// Who gives the variable its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the importer, constant during the run unless tunable.
    Parameter,
    /// Provided by another model.
    Input,
    /// Offered to other models.
    Output,
    /// Internal, shown but not to be connected.
    Local,
}

/// When the variable changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after initialisation.
    Fixed,
    /// Between communication points, by the importer.
    Tunable,
    /// At sample instants only.
    Discrete,
    /// At any time.
    Continuous,
}

/// How the variable is initialised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// With its start value.
    Exact,
    /// By calculation from other variables.
    Calculated,
}

/// A combination of causality, variability and initial that the table of FMI 2.0.4, section 2.2.7
/// permits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Role {
    /// Who gives the value.
    pub causality: Causality,
    /// When it changes.
    pub variability: Variability,
    /// How it is initialised; `None` for inputs, where the standard forbids it.
    pub initial: Option<Initial>,
}

impl Role {
    /// Parameter that is fixed once initialisation is over.
    pub const FIXED_PARAMETER: Self =
        Self::new(Causality::Parameter, Variability::Fixed, Some(Initial::Exact));
    /// Parameter that may change at communication points.
    pub const TUNABLE_PARAMETER: Self =
        Self::new(Causality::Parameter, Variability::Tunable, Some(Initial::Exact));
    /// Continuous-time input.
    pub const INPUT: Self = Self::new(Causality::Input, Variability::Continuous, None);
    /// Input that changes at sample instants only.
    pub const DISCRETE_INPUT: Self = Self::new(Causality::Input, Variability::Discrete, None);
    /// Sampled output.
    pub const OUTPUT: Self =
        Self::new(Causality::Output, Variability::Discrete, Some(Initial::Calculated));
    /// Sampled local variable.
    pub const LOCAL: Self =
        Self::new(Causality::Local, Variability::Discrete, Some(Initial::Calculated));
    /// Local variable that follows from parameters alone.
    pub const FIXED_LOCAL: Self =
        Self::new(Causality::Local, Variability::Fixed, Some(Initial::Calculated));
    /// Figure that is part of the binary.
    pub const CONSTANT: Self =
        Self::new(Causality::Local, Variability::Constant, Some(Initial::Exact));

    const fn new(causality: Causality, variability: Variability, initial: Option<Initial>) -> Self {
        Self { causality, variability, initial }
    }

    /// Whether the standard asks for a `start` value (otherwise it forbids one).
    pub const fn has_start(self) -> bool {
        matches!(self.causality, Causality::Input) || matches!(self.initial, Some(Initial::Exact))
    }
}

/// One value of an [`EnumerationType`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EnumerationItem {
    /// Name shown by importers.
    pub name: &'static str,
    /// What it means.
    pub description: &'static str,
}

/// A named enumeration; its items count from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EnumerationType {
    /// Name of the type.
    pub name: &'static str,
    /// What it describes.
    pub description: &'static str,
    /// Items; the value of the first is 1.
    pub items: &'static [EnumerationItem],
}

/// Data of a Real variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealKind {
    /// Unit of the exchanged value.
    pub unit: &'static Unit,
    /// Smallest allowed value.
    pub min: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Typical magnitude, positive.
    pub nominal: Option<f64>,
}

/// Type of a variable, with what FMI lets that type declare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// fmi2Real.
    Real(RealKind),
    /// fmi2Integer.
    Integer {
        /// Smallest allowed value.
        min: i32,
        /// Largest allowed value.
        max: i32,
    },
    /// fmi2Boolean.
    Boolean,
    /// fmi2String.
    String,
    /// fmi2Integer with named values.
    Enumeration(&'static EnumerationType),
}

impl Kind {
    /// Real in `unit`, without limits.
    pub const fn real(unit: &'static Unit) -> Self {
        Self::Real(RealKind { unit, min: None, max: None, nominal: None })
    }

    /// Integer that holds the values of an enumeration.
    pub const fn index_of(enumeration: &EnumerationType) -> Self {
        Self::Integer { min: 1, max: enumeration.items.len() as i32 }
    }

    /// The same with a lower limit; other types stay as they are.
    pub const fn min(self, min: f64) -> Self {
        match self {
            Self::Real(real) => Self::Real(RealKind { min: Some(min), ..real }),
            other => other,
        }
    }

    /// The same with an upper limit; other types stay as they are.
    pub const fn max(self, max: f64) -> Self {
        match self {
            Self::Real(real) => Self::Real(RealKind { max: Some(max), ..real }),
            other => other,
        }
    }

    /// The same with a typical magnitude; other types stay as they are.
    pub const fn nominal(self, nominal: f64) -> Self {
        match self {
            Self::Real(real) => Self::Real(RealKind { nominal: Some(nominal), ..real }),
            other => other,
        }
    }

    /// Name of the type in messages and as XML element.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Real(_) => "Real",
            Self::Integer { .. } => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
            Self::Enumeration(_) => "Enumeration",
        }
    }

    /// Whether `value` is of this type.
    pub const fn is_type_of(&self, value: Value<'_>) -> bool {
        matches!(
            (self, value),
            (Self::Real(_), Value::Real(_))
                | (Self::Integer { .. } | Self::Enumeration(_), Value::Integer(_))
                | (Self::Boolean, Value::Boolean(_))
                | (Self::String, Value::String(_))
        )
    }

    /// Whether `value` is of this type, finite and within the declared limits.
    pub fn admits(&self, value: Value<'_>) -> bool {
        match (self, value) {
            (Self::Real(real), Value::Real(value)) => {
                value.is_finite()
                    && real.min.is_none_or(|min| value >= min)
                    && real.max.is_none_or(|max| value <= max)
            }
            (Self::Integer { min, max }, Value::Integer(value)) => (*min..=*max).contains(&value),
            (Self::Enumeration(enumeration), Value::Integer(value)) => {
                value >= 1 && value as usize <= enumeration.items.len()
            }
            (Self::Boolean, Value::Boolean(_)) | (Self::String, Value::String(_)) => true,
            _ => false,
        }
    }
}

/// A value of any FMI 2.0 type; enumerations travel as `Integer`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// fmi2Real.
    Real(f64),
    /// fmi2Integer, also for enumerations.
    Integer(i32),
    /// fmi2Boolean.
    Boolean(bool),
    /// fmi2String: NUL-terminated, because `fmi2GetString` hands out the pointer.
    String(&'a CStr),
}

impl Value<'_> {
    /// Stores a Real; other types leave `place` as it is.
    pub fn store_real(self, place: &mut f64) {
        if let Self::Real(value) = self {
            *place = value;
        }
    }

    /// Stores an Integer; other types leave `place` as it is.
    pub fn store_integer(self, place: &mut i32) {
        if let Self::Integer(value) = self {
            *place = value;
        }
    }

    /// Stores a Boolean; other types leave `place` as it is.
    pub fn store_boolean(self, place: &mut bool) {
        if let Self::Boolean(value) = self {
            *place = value;
        }
    }
}

/// One variable of the description.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// Name in the structured naming convention.
    pub name: &'static str,
    /// One sentence for a graphical importer.
    pub description: &'static str,
    /// Causality, variability and initial.
    pub role: Role,
    /// Type, unit and limits.
    pub kind: Kind,
}

/// What an output depends on without a communication step between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dependencies<V: 'static> {
    /// The output.
    pub output: V,
    /// Inputs that it follows at a communication point.
    pub inputs: &'static [V],
    /// Inputs and parameters that it follows until the end of Initialization Mode.
    pub initial: &'static [V],
}

/// The variables of a model as a fieldless enumeration, made by [`variables!`](crate::variables).
pub trait VariableSet: Copy + PartialEq + core::fmt::Debug + 'static {
    /// All variables; the value reference is the index.
    const ALL: &'static [Self];
    /// Their data, in the same order.
    const TABLE: &'static [Variable];
    /// What outputs depend on at once; an output that is not named depends on nothing.
    const DEPENDENCIES: &'static [Dependencies<Self>] = &[];

    /// Value reference.
    fn value_reference(self) -> u32;
}

/// Declares the variables of a model: a fieldless enumeration, so that a model's `get` and `set`
/// are exhaustive matches, and the table of their data in value-reference order. A second block may
/// follow for [`VariableSet::DEPENDENCIES`]: output, inputs, initial.
///
/// ```
/// use steerguard_model_description::{Kind, Role, VariableSet, unit, variables};
///
/// variables! {
///     /// The variables of a toy.
///     pub enum Toy {
///         Speed, "v", "Speed.", Role::INPUT, Kind::real(&unit::METRE_PER_SECOND);
///         Alarm, "alarm", "True while too fast.", Role::OUTPUT, Kind::Boolean;
///     }
/// }
/// assert_eq!(Toy::Alarm.value_reference(), 1);
/// assert_eq!(Toy::TABLE[1].name, "alarm");
/// ```
#[macro_export]
macro_rules! variables {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $set:ident {
            $($variable:ident, $name:literal, $description:literal, $role:expr, $kind:expr;)+
        }
        $(dependencies {
            $($output:ident: [$($input:ident),*], [$($known:ident),*];)+
        })?
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u32)]
        $visibility enum $set {
            $(#[doc = concat!("`", $name, "`: ", $description)] $variable,)+
        }

        impl $crate::VariableSet for $set {
            const ALL: &'static [Self] = &[$(Self::$variable),+];
            const TABLE: &'static [$crate::Variable] = &[
                $($crate::Variable {
                    name: $name,
                    description: $description,
                    role: $role,
                    kind: $kind,
                }),+
            ];
            $(const DEPENDENCIES: &'static [$crate::Dependencies<Self>] = &[
                $($crate::Dependencies {
                    output: Self::$output,
                    inputs: &[$(Self::$input),*],
                    initial: &[$(Self::$known),*],
                }),+
            ];)?

            fn value_reference(self) -> u32 {
                self as u32
            }
        }
    };
}

/// Declares an enumeration that importers see: a fieldless `enum` and its [`EnumerationType`], whose
/// items have the same names.
///
/// ```
/// use steerguard_model_description::enumeration;
///
/// enumeration! {
///     /// What a toy does.
///     pub enum Mode: "Mode", "What the toy does" {
///         Run, "Integrates";
///         Rest, "Holds its output";
///     }
/// }
/// assert_eq!((Mode::TYPE.items[1].name, Mode::Rest.value()), ("Rest", 2));
/// ```
#[macro_export]
macro_rules! enumeration {
    (
        $(#[$attribute:meta])*
        $visibility:vis enum $set:ident: $name:literal, $description:literal {
            $($item:ident, $meaning:literal;)+
        }
    ) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u8)]
        $visibility enum $set {
            $(#[doc = concat!($meaning, ".")] $item,)+
        }

        impl $set {
            /// All items in the order of their values.
            $visibility const ALL: &'static [Self] = &[$(Self::$item),+];
            /// The type as the description states it.
            $visibility const TYPE: $crate::EnumerationType = $crate::EnumerationType {
                name: $name,
                description: $description,
                items: &[$($crate::EnumerationItem {
                    name: stringify!($item),
                    description: $meaning,
                }),+],
            };

            /// The value that stands for the item; the first is 1.
            $visibility const fn value(self) -> i32 {
                self as i32 + 1
            }
        }
    };
}

/// The log categories of FMI 2.0.4, section 2.2.4 that the FMUs use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum LogCategory {
    /// State changes of the model.
    Events,
    /// Accompanies fmi2Warning.
    StatusWarning,
    /// Accompanies fmi2Discard.
    StatusDiscard,
    /// Accompanies fmi2Error.
    StatusError,
    /// Accompanies fmi2Fatal.
    StatusFatal,
    /// Stands for all of them.
    All,
}

impl LogCategory {
    /// All categories.
    pub const ALL: [Self; 6] = [
        Self::Events,
        Self::StatusWarning,
        Self::StatusDiscard,
        Self::StatusError,
        Self::StatusFatal,
        Self::All,
    ];

    /// The standard's name.
    pub const fn name(self) -> &'static CStr {
        match self {
            Self::Events => c"logEvents",
            Self::StatusWarning => c"logStatusWarning",
            Self::StatusDiscard => c"logStatusDiscard",
            Self::StatusError => c"logStatusError",
            Self::StatusFatal => c"logStatusFatal",
            Self::All => c"logAll",
        }
    }

    /// What it holds, for a graphical importer.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Events => "State changes of the model",
            Self::StatusWarning => "Messages that accompany fmi2Warning",
            Self::StatusDiscard => "Messages that accompany fmi2Discard",
            Self::StatusError => "Messages that accompany fmi2Error",
            Self::StatusFatal => "Messages that accompany fmi2Fatal",
            Self::All => "All messages",
        }
    }
}

/// What the description says about the model as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelInfo {
    /// Name for people.
    pub name: &'static str,
    /// C identifier: the base name of the shared library.
    pub identifier: &'static str,
    /// What the model does, in one or two sentences.
    pub description: &'static str,
}

/// Proposed settings of a simulation run, in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultExperiment {
    /// Start time, s.
    pub start_time: f64,
    /// Stop time, s.
    pub stop_time: f64,
    /// Communication step, s.
    pub step_size: f64,
}
