//! `modelDescription.xml`: rendering, reading, lint.
