//! Records that become rows of a table: fields are written once, as struct, JSON keys and columns.

/// Type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers.
    Integer,
    /// Numbers.
    Real,
    /// Numbers, or nothing.
    OptionalReal,
    /// Names.
    Text,
}

/// What a cell of the table holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A number, or nothing.
    Real(Option<f64>),
    /// A name.
    Text(&'static str),
}

/// A type of cells.
pub trait Cell {
    /// Type of its column.
    const KIND: Kind;
    /// What the cell holds.
    fn value(&self) -> Value;
}

macro_rules! cells {
    ($($type:ty: $Kind:ident, $self:ident => $value:expr;)+) => {
        $(impl Cell for $type {
            const KIND: Kind = Kind::$Kind;

            fn value(&$self) -> Value {
                $value
            }
        })+
    };
}

cells! {
    // Indices stay below 2^63.
    u64: Integer, self => Value::Integer(self.cast_signed());
    u32: Integer, self => Value::Integer((*self).into());
    i32: Integer, self => Value::Integer((*self).into());
    f64: Real, self => Value::Real(Some(*self));
    Option<f64>: OptionalReal, self => Value::Real(*self);
}

/// A column of records `R`: its name, its type and how to read its cell.
pub type Column<R> = (&'static str, Kind, fn(&R) -> Value);

/// Defines a record with its columns.
macro_rules! record {
    (
        $(#[$attribute:meta])*
        pub struct $Name:ident { $($(#[$field_attribute:meta])* pub $field:ident: $type:ty,)+ }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq, schemars::JsonSchema, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $Name { $($(#[$field_attribute])* pub $field: $type,)+ }

        impl $Name {
            /// Columns in the order of the fields.
            pub const COLUMNS: &'static [$crate::campaign::record::Column<Self>] = &[
                $((stringify!($field), <$type as $crate::campaign::record::Cell>::KIND, |record| {
                    $crate::campaign::record::Cell::value(&record.$field)
                }),)+
            ];
        }
    };
}

/// Defines an enumeration with a name for each item.
macro_rules! named {
    (
        $(#[$attribute:meta])*
        pub enum $Name:ident { $($(#[$item_attribute:meta])* $Item:ident = $name:literal,)+ }
    ) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, schemars::JsonSchema, serde::Serialize, serde::Deserialize)]
        pub enum $Name { $($(#[$item_attribute])* #[serde(rename = $name)] $Item,)+ }

        impl $Name {
            /// All items.
            pub const ALL: &'static [Self] = &[$(Self::$Item,)+];

            /// Its name in files and tables.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$Item => $name,)+ }
            }
        }

        impl $crate::campaign::record::Cell for $Name {
            const KIND: $crate::campaign::record::Kind = $crate::campaign::record::Kind::Text;

            fn value(&self) -> $crate::campaign::record::Value {
                $crate::campaign::record::Value::Text(self.name())
            }
        }
    };
}

pub(super) use {named, record};
