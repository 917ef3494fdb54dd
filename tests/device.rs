//! Tests of the whole application on a device.
