//! Accepted configurations, and the defaults.

use super::*;
use crate::codec::SettingValue;
use crate::pipeline::{ByteOrder, FilePath, TransferDomain, VolumeSource};
use crate::render::{Camera, Filter, Projection};
use crate::volume::{Extent, SampleType, StoredType, ValueRange};

#[test]
fn the_example_reads_as_it_stands() {
    let experiment = read(EXAMPLE, &[]).unwrap();
    assert_eq!((experiment.name.as_str(), experiment.seed), ("compare", 1));
    let VolumeSource::File { files, raw: None, spacing: None } = &experiment.volumes[0].source else {
        panic!("a file")
    };
    let written: Vec<&str> = files.iter().map(FilePath::written).collect();
    assert_eq!(written, ["$CVR_DATA/bonsai.nrrd"]);
    assert_eq!(experiment.codecs[0].sweeps, []);
    let [block, bits] = experiment.codecs[1].sweeps.as_slice() else { panic!("two sweeps") };
    assert_eq!(block.values, ["4", "8", "8x8x4"].map(|v| SettingValue::Text(v.to_owned())));
    assert_eq!(bits.values, [SettingValue::Integer(2), SettingValue::Integer(4)]);
    assert_eq!(experiment.pipeline.filters, [Filter::Nearest, Filter::Linear]);
    assert_eq!(experiment.pipeline.skipping, [false], "nothing is skipped unless it is asked for");
    let scene = experiment.scene("front").unwrap();
    assert_eq!(scene.camera, Camera::default());
    assert_eq!(scene.control_points[1].rgba, [61.0, 122.0, 42.0, 32.0].map(|c| c / 255.0));
    assert_eq!((scene.step_voxels, scene.early_termination), (0.5, 0.999));
    assert_eq!((scene.domain, scene.background), (TransferDomain::Data, [0.0; 3]));
}

#[test]
fn little_needs_to_be_written() {
    let text = "experiment.name = 'x'\n[[volume]]\nname = 'v'\ngenerate = 'shepp-logan'\n[[codec]]\nid = 'raw'\n\
                [pipeline]\nrenderer = 'slicing'\nsite = 'host'\nfilter = 'linear'\n\
                [[scene]]\nname = 's'\ntransfer_function = [[0, '#000000'], [1, '#ffffff80']]\n";
    let experiment = read(text, &[]).unwrap();
    let expected = VolumeSource::Generated {
        generator: "shepp-logan".to_owned(),
        extent: Extent::cube(64).unwrap(),
        frames: 1,
        sample: SampleType::U8,
    };
    assert_eq!(experiment.volumes[0].source, expected);
    assert_eq!((experiment.seed, experiment.scenes[0].size), (0, [256, 256]));
    assert_eq!(experiment.scenes[0].control_points[0].rgba[3], 1.0, "six digits are opaque");
}

#[test]
fn settings_belong_to_the_renderers_that_have_them() {
    let pipeline = |set: &[&str]| read(EXAMPLE, set).unwrap().pipeline;
    let both = "pipeline.renderer=[\"raycasting\", \"slicing\"]";
    let geometry = "pipeline.geometry=[\"planes\", \"axis\"]";
    assert_eq!(pipeline(&[both]).renderers, ["raycasting", "slicing"]);
    assert_eq!(pipeline(&[both, geometry]).renderers, ["raycasting", "slicing", "slicing,geometry=axis"]);
    let renderers = pipeline(&["pipeline.renderer=slicing", "pipeline.layers=[2, 1]", geometry]).renderers;
    let expected = ["slicing,layers=2", "slicing,geometry=axis,layers=2", "slicing", "slicing,geometry=axis"];
    assert_eq!(renderers, expected, "the first-written setting varies slowest");
    let repeated = "pipeline.geometry=[\"axis\", \"planes\", \"axis\"]";
    assert_eq!(
        pipeline(&["pipeline.renderer=slicing", repeated]).renderers,
        ["slicing,geometry=axis", "slicing"]
    );
    assert_eq!(pipeline(&["pipeline.skipping=true"]).skipping, [true]);
    assert_eq!(pipeline(&["pipeline.skipping=[false, true]"]).skipping, [false, true]);
    assert_eq!(pipeline(&[]).stages, [None], "all, unless fewer are asked for");
    assert_eq!(pipeline(&["pipeline.stages=2"]).stages, [Some(2)]);
    assert_eq!(pipeline(&["pipeline.stages=[\"all\", 1, 254]"]).stages, [None, Some(1), Some(254)]);
    assert_eq!(pipeline(&[]).resolutions, [0], "the full one, unless another is asked for");
    assert_eq!(pipeline(&["pipeline.resolution=[2, 0, 32]"]).resolutions, [2, 0, 32]);
}

#[test]
fn every_key_is_read() {
    let text = edited(
        "file = \"$CVR_DATA/bonsai.nrrd\"",
        "file = 'x.raw'\ndims = [3, 4, 5]\nframes = 6\nchannels = 3\ndtype = 'i64'\nbyte_order = 'big'\nspacing = [1, 2.5, 3]\nskip_bytes = 7",
    );
    let text = text.replace(
        "projection = \"perspective\" }",
        "projection = \"orthographic\", field_of_view = 45 }\nbackground = '#ff0000'\nearly_termination = 1\n\
         volumes = 'bonsai'\ntransfer_function_domain = 'data'",
    );
    let experiment = read(&text, &[]).unwrap();
    let VolumeSource::File { raw: Some(raw), .. } = &experiment.volumes[0].source else { panic!("raw") };
    assert_eq!((raw.extent.to_array(), raw.stored), ([3, 4, 5], StoredType::I64));
    assert_eq!((raw.frames, raw.channels), (6, 3));
    assert_eq!((raw.byte_order, raw.spacing, raw.skip_bytes), (ByteOrder::Big, [1.0, 2.5, 3.0], 7));
    let scene = &experiment.scenes[0];
    assert_eq!((scene.camera.projection, scene.camera.field_of_view), (Projection::Orthographic, 45.0));
    assert_eq!((scene.background, scene.early_termination), ([1.0, 0.0, 0.0], 1.0));
    assert_eq!(scene.volumes.as_deref(), Some(["bonsai".to_owned()].as_slice()));
}

#[test]
fn sequences_and_moving_volumes() {
    let source = |key: &str| {
        let text = edited("file = \"$CVR_DATA/bonsai.nrrd\"", key);
        read(&text, &[]).unwrap().volumes.remove(0).source
    };
    let files = |source: &VolumeSource| match source {
        VolumeSource::File { files, .. } => files.iter().map(|f| f.written().to_owned()).collect::<Vec<_>>(),
        VolumeSource::Generated { .. } => panic!("files"),
    };
    assert_eq!(files(&source("files = ['b.nrrd', 'a.nrrd', 'b.nrrd']")), ["b.nrrd", "a.nrrd", "b.nrrd"]);
    assert_eq!(files(&source("file = 'step*.raw'\ndims = [4, 4, 4]\ndtype = 'f64'")), ["step*.raw"]);
    let VolumeSource::File { raw: None, spacing, .. } = source("file = 'ct.tif'\nspacing = [1, 1, 2.5]")
    else {
        panic!("no headerless file")
    };
    assert_eq!(spacing, Some([1.0, 1.0, 2.5]), "spacing alone makes no file headerless");
    let VolumeSource::Generated { frames, .. } = source("generate = 'shepp-logan'\nframes = 24") else {
        panic!("generated")
    };
    assert_eq!(frames, 24);
}

#[test]
fn a_view_has_the_transfer_function_in_data_units() {
    let range = ValueRange { min: -100.0, max: 300.0 };
    let mut scene = read(EXAMPLE, &[]).unwrap().scenes.remove(0);
    let view = scene.view(range, Filter::Linear).unwrap();
    assert_eq!(view.transfer_function.domain(), ValueRange { min: 40.0, max: 255.0 });
    assert_eq!((view.termination, view.filter), (0.999, Filter::Linear));

    scene.domain = TransferDomain::Range;
    for (point, value) in scene.control_points.iter_mut().zip([0.0, 0.25, 0.5, 1.0]) {
        point.value = value;
    }
    let values = |range| -> Vec<f32> {
        scene.transfer_function(range).unwrap().points().iter().map(|p| p.value).collect()
    };
    assert_eq!(values(range), [-100.0, 0.0, 100.0, 300.0]);
    assert_eq!(values(ValueRange { min: 7.0, max: 7.0 }), [7.0, 7.25, 7.5, 8.0], "a volume of one value");
    for extreme in [f32::MAX, f32::MIN, 0.0, 1e-38] {
        assert!(scene.transfer_function(ValueRange { min: extreme, max: extreme }).is_ok(), "{extreme}");
    }
    assert!(scene.transfer_function(ValueRange { min: f32::MIN, max: f32::MAX }).is_ok());
}

#[test]
fn other_volumes_by_the_same_recipe() {
    let mut experiment = read(&edited("size = [256, 256]", "volumes = ['bonsai']"), &[]).unwrap();
    let mut other = experiment.volumes[0].clone();
    other.name = "mine".to_owned();
    let before = experiment.clone();
    assert_eq!(experiment.replace_volumes(vec![other.clone()]).unwrap_err().volume, "mine");
    assert_eq!(experiment, before);
    experiment.scenes[0].volumes = None;
    experiment.replace_volumes(vec![other]).unwrap();
    assert_eq!(experiment.scenes_of("mine").count(), 1);
}
