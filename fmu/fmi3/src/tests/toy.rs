//! A model with one variable of each sort, and an array; its flag follows a Real input's sign.

use std::ffi::CStr;

use steerguard_fmu_core::{Archive, Log, Model, Status};
use steerguard_model_description::structure::{Array, Structure, Terminal, TriggeredClock};
use steerguard_model_description::{
    EnumerationItem, EnumerationType, Kind, ModelInfo, Role, Value, unit, variables,
};

/// Sample period of the toy, s.
pub const PERIOD: f64 = 0.01;
pub const PAYLOAD: [u8; 8] = PERIOD.to_le_bytes();

const MODE: EnumerationType = EnumerationType {
    name: "Mode",
    description: "What the toy does",
    items: &[
        EnumerationItem { name: "Run", description: "Counts samples" },
        EnumerationItem { name: "Fail", description: "Cannot be initialised" },
    ],
};

variables! {
    /// The variables of the toy.
    pub enum ToyVariable {
        Input, "u", "Input", Role::INPUT, Kind::real(&unit::ONE).min(-1.0).max(1.0);
        Order, "order", "Whole-numbered input", Role::INPUT, Kind::Integer { min: -4, max: 0 };
        Flag, "flag", "Whether u is positive", Role::OUTPUT, Kind::Boolean;
        Samples, "samples", "Samples run", Role::LOCAL, Kind::Integer { min: 0, max: i32::MAX };
        First, "x[1]", "First", Role::TUNABLE_PARAMETER, Kind::real(&unit::ONE).max(10.0);
        Second, "x[2]", "Second", Role::TUNABLE_PARAMETER, Kind::real(&unit::ONE).max(10.0);
        Offset, "offset", "Fixed", Role::FIXED_PARAMETER, Kind::real(&unit::ONE);
        Mode, "mode", "Mode", Role::FIXED_PARAMETER, Kind::Enumeration(&MODE);
        Label, "label", "Any text", Role::FIXED_PARAMETER, Kind::String;
        Hold, "hold", "Leave the flag", Role::TUNABLE_PARAMETER, Kind::Boolean;
    }
}

impl Structure for ToyVariable {
    const ARRAYS: &'static [Array<Self>] =
        &[Array { name: "x", description: "Two numbers", elements: &[Self::First, Self::Second] }];
    const CLOCK: TriggeredClock<Self> = TriggeredClock {
        watched: Self::Flag,
        name: "change",
        description: "The flag changes",
        time_name: "change_time",
        time_description: "When it did",
    };
    const TERMINALS: &'static [Terminal<Self>] = &[];
}

/// Value references beyond the table.
pub const CLOCK: u32 = 10;
pub const CLOCK_TIME: u32 = 11;
pub const TIME: u32 = 12;

use ToyVariable as V;

#[derive(Clone)]
pub struct Toy {
    period: f64,
    input: f64,
    order: i32,
    flag: bool,
    samples: i32,
    x: [f64; 2],
    offset: f64,
    mode: i32,
    label: [u8; 16],
    hold: bool,
}

impl Model for Toy {
    type Variable = ToyVariable;
    const INFO: ModelInfo = ModelInfo { name: "Toy", identifier: "Toy", description: "A toy" };

    fn new(payload: &[u8]) -> Result<Self, &'static str> {
        let period = <[u8; 8]>::try_from(payload).map_err(|_| "the toy's payload is no number")?;
        Ok(Self {
            period: f64::from_le_bytes(period),
            input: 0.0,
            order: 0,
            flag: false,
            samples: 0,
            x: [1.0, 2.0],
            offset: 0.0,
            mode: 1,
            label: [0; 16],
            hold: false,
        })
    }

    fn sample_period_s(&self) -> f64 {
        self.period
    }

    fn get(&self, variable: V) -> Value<'_> {
        match variable {
            V::Input => Value::Real(self.input),
            V::Order => Value::Integer(self.order),
            V::Flag => Value::Boolean(self.flag),
            V::Samples => Value::Integer(self.samples),
            V::First => Value::Real(self.x[0]),
            V::Second => Value::Real(self.x[1]),
            V::Offset => Value::Real(self.offset),
            V::Mode => Value::Integer(self.mode),
            V::Label => Value::String(CStr::from_bytes_until_nul(&self.label).unwrap()),
            V::Hold => Value::Boolean(self.hold),
        }
    }

    fn set(&mut self, variable: V, value: Value<'_>) {
        match variable {
            V::Input => value.store_real(&mut self.input),
            V::Order => value.store_integer(&mut self.order),
            V::First => value.store_real(&mut self.x[0]),
            V::Second => value.store_real(&mut self.x[1]),
            V::Offset => value.store_real(&mut self.offset),
            V::Mode => value.store_integer(&mut self.mode),
            V::Hold => value.store_boolean(&mut self.hold),
            V::Label => {
                let Value::String(text) = value else { unreachable!() };
                let length = text.count_bytes().min(15);
                self.label = [0; 16];
                self.label[..length].copy_from_slice(&text.to_bytes()[..length]);
            }
            V::Flag | V::Samples => unreachable!(),
        }
    }

    fn initialise(&mut self, _start_time_s: f64) -> Result<(), &'static str> {
        if self.mode == 2 { Err("the toy was told to fail") } else { Ok(()) }
    }

    /// The flag follows the input at every sample; with an input of NaN it changes at every third.
    fn sample(&mut self, log: &Log<'_>) -> Status {
        match self.order {
            -1 => return Status::Discard,
            -2 => {
                log.error(|text| {
                    text.str("the toy broke");
                });
                return Status::Error;
            }
            -3 => return Status::Fatal,
            _ => {}
        }
        self.samples += 1;
        if self.input.is_nan() {
            self.flag ^= self.samples % 3 == 0;
        } else if !self.hold {
            self.flag = self.input > 0.0;
        }
        Status::Ok
    }

    fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.input);
        let mut order = self.order.unsigned_abs();
        archive.u32(&mut order);
        self.order = -(order as i32);
        archive.flag(&mut self.flag);
        let mut samples = self.samples as u32;
        archive.u32(&mut samples);
        self.samples = samples as i32;
        for number in self.x.iter_mut().chain([&mut self.offset]) {
            archive.finite(number);
        }
        archive.choice(&mut self.mode, &[1, 2]);
        archive.bytes(&mut self.label);
        archive.require(self.label[15] == 0);
        archive.flag(&mut self.hold);
    }
}
