//! What FMI 3.0 says of a model's variables beyond the table: arrays, a triggered clock, terminals.
//!
//! # Conventions
//! - A variable keeps its value reference; an array has that of its first element, and the other elements
//!   have none. What FMI 3.0 alone has comes after the table: the clock, its time, the independent variable.
//! - Terms are those of FMI 3.0.2, section 2.4.7 (variables) and 2.4.9 (terminals).

use crate::{Kind, VariableSet};

/// Variables that stand next to each other in the table and are one array of one dimension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Array<V: 'static> {
    /// Name of the array.
    pub name: &'static str,
    /// One sentence for a graphical importer; it states the units where they differ.
    pub description: &'static str,
    /// Its elements, which are of one type and role.
    pub elements: &'static [V],
}

/// An output clock of `intervalVariability` triggered: it ticks at samples after which a Boolean variable
/// is another than before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriggeredClock<V: 'static> {
    /// The Boolean variable.
    pub watched: V,
    /// Name of the clock.
    pub name: &'static str,
    /// What a tick means.
    pub description: &'static str,
    /// Name of the clocked output that holds the time of the last tick, s.
    pub time_name: &'static str,
    /// What it is.
    pub time_description: &'static str,
}

/// Value of a clock's time before its first tick, s.
pub const NO_TICK_TIME: f64 = -1.0;

/// How two terminals are wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatchingRule {
    /// Each member to that of its name; both have the same members.
    Plug,
    /// Each member to that of its name, where the other has one.
    Bus,
}

/// What a member of a terminal is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Member<V: 'static> {
    /// A variable of the table that is no element of an array.
    Variable(V),
    /// The array of this index.
    Array(usize),
    /// The clock.
    Clock,
    /// The time of the clock's last tick.
    ClockTime,
}

/// Variables that belong together where a model is wired.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terminal<V: 'static> {
    /// Name of the terminal.
    pub name: &'static str,
    /// What goes through it.
    pub description: &'static str,
    /// How it is wired.
    pub matching_rule: MatchingRule,
    /// Names and members.
    pub members: &'static [(&'static str, Member<V>)],
}

/// The variables of a model that is offered in FMI 3.0.
pub trait Structure: VariableSet {
    /// Arrays, in the order of the table.
    const ARRAYS: &'static [Array<Self>];
    /// The clock.
    const CLOCK: TriggeredClock<Self>;
    /// Terminals.
    const TERMINALS: &'static [Terminal<Self>];
}

/// What a value reference stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Entry<V: 'static> {
    /// A variable of the table, or the elements of an array.
    Elements(&'static [V]),
    /// The clock.
    Clock,
    /// The time of the clock's last tick.
    ClockTime,
    /// The independent variable.
    Time,
}

/// What `reference` stands for, if anything.
#[inline]
pub fn entry<V: Structure>(reference: u32) -> Option<Entry<V>> {
    let index = reference as usize;
    let beyond = index.checked_sub(V::ALL.len());
    match beyond {
        Some(0) => return Some(Entry::Clock),
        Some(1) => return Some(Entry::ClockTime),
        Some(2) => return Some(Entry::Time),
        Some(_) => return None,
        None => {}
    }
    let alone = V::ALL.get(index..=index)?;
    let variable = alone.first()?;
    for array in V::ARRAYS {
        match array.elements.iter().position(|element| element == variable) {
            Some(0) => return Some(Entry::Elements(array.elements)),
            Some(_) => return None,
            None => {}
        }
    }
    Some(Entry::Elements(alone))
}

/// Value reference of the clock, of its time and of the independent variable.
pub const fn references_beyond_the_table<V: Structure>() -> [u32; 3] {
    let clock = V::ALL.len() as u32;
    [clock, clock + 1, clock + 2]
}

/// Name of a type in FMI 3.0, as XML element and in the names of functions; an Enumeration is got and set as
/// Int64.
pub const fn type_name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Real(_) => "Float64",
        Kind::Integer { .. } => "Int32",
        Kind::Boolean => "Boolean",
        Kind::String => "String",
        Kind::Enumeration(_) => "Enumeration",
    }
}
