//! Log messages by category.

use steerguard_model_description::LogCategory;

use crate::Text;

/// Categories that are enabled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Categories(u8);

impl Categories {
    /// None.
    pub const NONE: Self = Self(0);

    /// Enables one more.
    pub fn enable(&mut self, category: LogCategory) {
        self.0 |= match category {
            LogCategory::All => u8::MAX,
            one => 1 << one as u8,
        };
    }

    /// Whether messages of a category are to be sent.
    pub const fn contain(self, category: LogCategory) -> bool {
        self.0 & (1 << category as u8) != 0
    }
}

/// What takes the messages.
pub trait Logger {
    /// Categories that are enabled.
    fn categories(&self) -> Categories;

    /// Sends a message whatever is enabled.
    fn send(&self, category: LogCategory, text: &Text);
}

/// Where a model reports what happens in a sample.
#[derive(Clone, Copy)]
pub struct Log<'a>(&'a dyn Logger);

impl<'a> Log<'a> {
    /// A log that `logger` takes the messages of.
    pub fn new(logger: &'a dyn Logger) -> Self {
        Self(logger)
    }

    /// Sends a message if its category is enabled; the text is made only then.
    pub fn message(&self, category: LogCategory, write: impl FnOnce(&mut Text)) {
        if self.0.categories().contain(category) {
            self.message_anyway(category, write);
        }
    }

    /// Sends a message whatever is enabled.
    #[cold]
    pub fn message_anyway(&self, category: LogCategory, write: impl FnOnce(&mut Text)) {
        let mut text = Text::new();
        write(&mut text);
        self.0.send(category, &text);
    }

    /// Reports a change of state.
    pub fn event(&self, write: impl FnOnce(&mut Text)) {
        self.message(LogCategory::Events, write);
    }

    /// Reports a warning; the model returns [`Status::Warning`](crate::Status) from the same sample.
    pub fn warning(&self, write: impl FnOnce(&mut Text)) {
        self.message(LogCategory::StatusWarning, write);
    }

    /// Reports why a sample failed; the model returns [`Status::Error`](crate::Status) from the same
    /// sample.
    pub fn error(&self, write: impl FnOnce(&mut Text)) {
        self.message(LogCategory::StatusError, write);
    }
}
