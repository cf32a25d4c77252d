//! Getting and setting values; an array takes as many places as it has elements.

use steerguard_fmu_core::foreign::{array, array_mut, string};
use steerguard_fmu_core::{AccessRefusal, Model};
use steerguard_model_description::structure::{Entry, Structure, TriggeredClock};
use steerguard_model_description::{Kind, Value, VariableSet};

use super::call::{Fmi3, OK, call};
use crate::Function;
use crate::instance::Instance;
use crate::types::*;

/// A type of FMI 3.0 that variables have, as C passes it.
trait Passed: Copy {
    /// Whether variables of `kind` are got and set by it.
    fn is_of(kind: &Kind) -> bool;

    /// A value of such a variable.
    fn from_value(value: Value<'_>) -> Option<Self>;
}

impl Passed for fmi3Float64 {
    fn is_of(kind: &Kind) -> bool {
        matches!(kind, Kind::Real(_))
    }

    #[inline(always)]
    fn from_value(value: Value<'_>) -> Option<Self> {
        if let Value::Real(real) = value { Some(real) } else { None }
    }
}

impl Passed for fmi3Int32 {
    fn is_of(kind: &Kind) -> bool {
        matches!(kind, Kind::Integer { .. })
    }

    #[inline(always)]
    fn from_value(value: Value<'_>) -> Option<Self> {
        if let Value::Integer(integer) = value { Some(integer) } else { None }
    }
}

impl Passed for fmi3Int64 {
    fn is_of(kind: &Kind) -> bool {
        matches!(kind, Kind::Enumeration(_))
    }

    #[inline(always)]
    fn from_value(value: Value<'_>) -> Option<Self> {
        if let Value::Integer(integer) = value { Some(integer.into()) } else { None }
    }
}

impl Passed for fmi3Boolean {
    fn is_of(kind: &Kind) -> bool {
        matches!(kind, Kind::Boolean)
    }

    #[inline(always)]
    fn from_value(value: Value<'_>) -> Option<Self> {
        if let Value::Boolean(boolean) = value { Some(boolean.into()) } else { None }
    }
}

impl Passed for fmi3String {
    fn is_of(kind: &Kind) -> bool {
        matches!(kind, Kind::String)
    }

    #[inline(always)]
    fn from_value(value: Value<'_>) -> Option<Self> {
        if let Value::String(text) = value { Some(text.as_ptr()) } else { None }
    }
}

impl<M: Model<Variable: Structure>> Instance<M> {
    /// What a value reference stands for, if it is a variable of the type `T`.
    ///
    /// # Errors
    /// The status of the refusal.
    #[inline(never)] // small code
    fn find_of_type<T: Passed>(
        &self,
        function: Function,
        vr: u32,
    ) -> Result<Entry<M::Variable>, fmi3Status> {
        let entry = self.find(function, vr)?;
        match entry {
            Entry::Elements(elements) => {
                let first = elements.first().map_or(vr, |first| first.value_reference());
                let row = <M::Variable as VariableSet>::TABLE.get(first as usize);
                match row {
                    Some(row) if !T::is_of(&row.kind) => {
                        Err(self.refuse_access(function, AccessRefusal::WrongType(row)))
                    }
                    _ => Ok(entry),
                }
            }
            // A time is got as a Real.
            Entry::Time | Entry::ClockTime if T::from_value(Value::Real(0.0)).is_some() => {
                Ok(entry)
            }
            Entry::Time | Entry::ClockTime | Entry::Clock => {
                let TriggeredClock { name, time_name, .. } = <M::Variable as Structure>::CLOCK;
                Err(self.refuse(function, |text| {
                    text.str("variable \"").str(match entry {
                        Entry::Clock => name,
                        Entry::ClockTime => time_name,
                        _ => "time",
                    });
                    text.str("\" is of type ");
                    text.str(if entry == Entry::Clock { "Clock" } else { "Float64" });
                }))
            }
        }
    }

    /// Refuses values that are more or fewer than the variables have elements.
    #[cold]
    fn refuse_count(&self, function: Function, elements: usize, values: usize) -> fmi3Status {
        self.refuse(function, |text| {
            text.str("the variables have ").integer(elements as i64);
            text.str(" elements, nValues is ").integer(values as i64);
        })
    }
}

/// Number of values that entries take.
fn count<V>(elements: usize, entry: &Entry<V>) -> usize {
    elements.saturating_add(match entry {
        Entry::Elements(of) => of.len(),
        _ => 1,
    })
}

/// Gets values of the type `T`.
unsafe fn get<F: Fmi3, T: Passed>(
    instance: fmi3Instance,
    function: Function,
    value_references: *const fmi3ValueReference,
    n_value_references: usize,
    values: *mut T,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, function, |instance, function| {
            let vr = array(value_references, n_value_references)
                .ok_or_else(|| instance.null(function, "valueReferences"))?;
            let values =
                array_mut(values, n_values).ok_or_else(|| instance.null(function, "values"))?;
            let mut elements = 0;
            for &vr in vr {
                elements = count(elements, &instance.find_of_type::<T>(function, vr)?);
            }
            if elements != values.len() {
                return Err(instance.refuse_count(function, elements, values.len()));
            }
            let mut values = values.iter_mut();
            for &vr in vr {
                let machine = &instance.machine;
                let time_s = match instance.find(function, vr)? {
                    Entry::Elements(variables) => {
                        for (&variable, value) in variables.iter().zip(&mut values) {
                            if let Some(got) = T::from_value(machine.run.model.get(variable)) {
                                value.write(got);
                            }
                        }
                        continue;
                    }
                    Entry::ClockTime => machine.tick.time_s,
                    Entry::Time | Entry::Clock => machine.run.clock.point,
                };
                if let Some((got, value)) = T::from_value(Value::Real(time_s)).zip(values.next()) {
                    value.write(got);
                }
            }
            Ok(OK)
        })
    }
}

/// Sets values, all of them or, where one is refused, none.
unsafe fn set<'a, F: Fmi3, T: Passed + 'a>(
    instance: fmi3Instance,
    function: Function,
    value_references: *const fmi3ValueReference,
    n_value_references: usize,
    values: *const T,
    n_values: usize,
    wrap: impl Fn(T) -> Option<Value<'a>>,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, function, |instance, function| {
            let vr = array(value_references, n_value_references)
                .ok_or_else(|| instance.null(function, "valueReferences"))?;
            let values =
                array(values, n_values).ok_or_else(|| instance.null(function, "values"))?;
            let mut elements = 0;
            for &vr in vr {
                elements = count(elements, &instance.find_of_type::<T>(function, vr)?);
            }
            if elements != values.len() {
                return Err(instance.refuse_count(function, elements, values.len()));
            }
            let mut given = values.iter();
            for &vr in vr {
                let Entry::Elements(variables) = instance.find(function, vr)? else {
                    let reason = "a time is the FMU's own and cannot be set";
                    return Err(instance.refuse_because(function, reason));
                };
                for (&variable, &value) in variables.iter().zip(&mut given) {
                    let value = wrap(value).ok_or_else(|| instance.no_value(function))?;
                    instance.settable(function, variable, value)?;
                }
            }
            let mut given = values.iter();
            for &vr in vr {
                let Entry::Elements(variables) = instance.find(function, vr)? else { continue };
                for (&variable, &value) in variables.iter().zip(&mut given) {
                    if let Some(value) = wrap(value) {
                        instance.machine.run.model.set(variable, value);
                    }
                }
            }
            Ok(OK)
        })
    }
}

impl<M: Model<Variable: Structure>> Instance<M> {
    /// Refuses what is no value of any variable.
    #[cold]
    fn no_value(&self, function: Function) -> fmi3Status {
        self.refuse_because(function, "a value is NULL, or no item of an enumeration")
    }
}

macro_rules! accessors {
    ($($get:ident, $set:ident: $type:ty, $wrap:expr;)+) => {$(
        pub unsafe fn $get<F: Fmi3>(
            instance: fmi3Instance,
            value_references: *const fmi3ValueReference,
            n_value_references: usize,
            values: *mut $type,
            n_values: usize,
        ) -> fmi3Status {
            let function = Function::$get;
            // SAFETY: the contract of this module.
            unsafe {
                get::<F, $type>(
                    instance, function, value_references, n_value_references, values, n_values,
                )
            }
        }

        pub unsafe fn $set<F: Fmi3>(
            instance: fmi3Instance,
            value_references: *const fmi3ValueReference,
            n_value_references: usize,
            values: *const $type,
            n_values: usize,
        ) -> fmi3Status {
            let function = Function::$set;
            // SAFETY: the contract of this module.
            unsafe {
                set::<F, $type>(
                    instance, function, value_references, n_value_references, values, n_values, $wrap,
                )
            }
        }
    )+};
}

accessors! {
    fmi3GetFloat64, fmi3SetFloat64: fmi3Float64, |real| Some(Value::Real(real));
    fmi3GetInt32, fmi3SetInt32: fmi3Int32, |integer| Some(Value::Integer(integer));
    fmi3GetInt64, fmi3SetInt64: fmi3Int64, |item| i32::try_from(item).ok().map(Value::Integer);
    fmi3GetBoolean, fmi3SetBoolean: fmi3Boolean, |boolean| Some(Value::Boolean(boolean != fmi3False));
    fmi3GetString, fmi3SetString: fmi3String, |pointer| string(pointer).map(Value::String);
}

/// Gets or sets variables of a type that no variable has: none at all, or the first is refused.
#[inline(never)] // small code: many functions are of types that no variable has
unsafe fn none<F: Fmi3>(
    instance: fmi3Instance,
    function: Function,
    value_references: *const fmi3ValueReference,
    n_value_references: usize,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, function, |instance, function| {
            let vr = array(value_references, n_value_references)
                .ok_or_else(|| instance.null(function, "valueReferences"))?;
            if vr.is_empty() {
                return Ok(OK);
            }
            Err(instance.refuse_because(function, "no variable is of this type"))
        })
    }
}

macro_rules! none_of {
    ($($function:ident($($value:ty),*);)+) => {$(
        pub unsafe fn $function<F: Fmi3>(
            instance: fmi3Instance,
            value_references: *const fmi3ValueReference,
            n_value_references: usize,
            $(_: $value,)*
            _n_values: usize,
        ) -> fmi3Status {
            let function = Function::$function;
            // SAFETY: the contract of this module.
            unsafe { none::<F>(instance, function, value_references, n_value_references) }
        }
    )+};
}

none_of! {
    fmi3GetFloat32(*mut fmi3Float32);
    fmi3GetInt8(*mut fmi3Int8);
    fmi3GetUInt8(*mut fmi3UInt8);
    fmi3GetInt16(*mut fmi3Int16);
    fmi3GetUInt16(*mut fmi3UInt16);
    fmi3GetUInt32(*mut fmi3UInt32);
    fmi3GetUInt64(*mut fmi3UInt64);
    fmi3GetBinary(*mut usize, *mut fmi3Binary);
    fmi3SetFloat32(*const fmi3Float32);
    fmi3SetInt8(*const fmi3Int8);
    fmi3SetUInt8(*const fmi3UInt8);
    fmi3SetInt16(*const fmi3Int16);
    fmi3SetUInt16(*const fmi3UInt16);
    fmi3SetUInt32(*const fmi3UInt32);
    fmi3SetUInt64(*const fmi3UInt64);
    fmi3SetBinary(*const usize, *const fmi3Binary);
}
