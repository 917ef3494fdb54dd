//! Text of bindings and accessors.
