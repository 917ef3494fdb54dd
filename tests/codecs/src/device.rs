//! The device on which the tests of codecs run shaders, if there is one. Codecs do not depend on it.

use std::sync::Arc;

use cvr_core::codec::{Codec, Settings, VoxelDump};
use cvr_core::conformance::{self, Property};
use cvr_engine::testing::test_device;

use crate::mutated::MutatedCodec;

/// The device for conformance tests. Without an adapter, or if `CVR_DEVICE` says so, they run without it and are logged
/// as device tests that did not run.
#[must_use]
pub fn dump(test_name: &str) -> Option<&'static dyn VoxelDump> {
    test_device(test_name).map(|device| device as &dyn VoxelDump)
}

/// The failing twin of a codec's conformance tests: a snippet in which `from` is replaced by `to` fails them, and only
/// for that reason.
pub fn notices(codec: Arc<dyn Codec>, from: &'static str, to: &'static str) {
    notices_under(codec, &[Settings::default()], from, to);
}

/// The same under some settings.
pub fn notices_under(codec: Arc<dyn Codec>, list: &[Settings], from: &'static str, to: &'static str) {
    let id = codec.info().id;
    let Some(device) = test_device(&format!("{id}::wrong_snippet")) else { return };
    let right = conformance::run_shaders(codec.as_ref(), list, device);
    right.assert_ok();
    assert!(right.shader_samples > 0, "{right}");
    let wrong = conformance::run_shaders(&MutatedCodec { inner: codec, from, to }, list, device);
    assert!(wrong.fails(Property::Parity), "{id}: `{to}` goes unnoticed");
    let told =
        |f: &conformance::Failure| f.property == Property::Parity && f.message.contains("the first is voxel");
    let other = wrong.failures.iter().find(|f| !told(f));
    assert!(other.is_none(), "{}", other.unwrap());
}
