//! Contract lints.
