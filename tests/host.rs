//! Tests of the whole application that need no device.
