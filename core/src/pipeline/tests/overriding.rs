//! `--set`.

use super::*;
use crate::codec::SettingValue;
use crate::pipeline::VolumeSource;
use crate::render::{Filter, Projection};

const TWO: &str =
    "[[scene]]\nname = \"side.view\"\ntransfer_function = [[0, \"#000000\"], [1, \"#ffffff\"]]\n";

#[test]
fn overrides_reach_tables_lists_and_names() {
    let set = [
        "scene.step_voxels=1.0",
        "scene.front.size = [8, 9]",
        "scene.\"side.view\".camera.zoom=2",
        "scene.front.camera.projection=orthographic",
        "experiment.seed=2",
        "codec.s3dc.block=8x8x4",
        "pipeline.filter=[\"linear\"]",
        "volume.bonsai.file=/a=b/$X.nrrd",
        "scene.background=\"#ffffff\"",
    ];
    let experiment = read(&format!("{EXAMPLE}{TWO}"), &set).unwrap_or_else(|e| panic!("{e}"));
    let [front, side] = experiment.scenes.as_slice() else { panic!("two scenes") };
    assert_eq!((front.step_voxels, side.step_voxels), (1.0, 1.0));
    assert_eq!((front.size, side.size), ([8, 9], [256, 256]));
    assert_eq!((front.camera.zoom, side.camera.zoom), (1.0, 2.0));
    assert_eq!(front.camera.projection, Projection::Orthographic);
    assert_eq!((front.background, experiment.seed), ([1.0; 3], 2));
    assert_eq!(experiment.codecs[1].sweeps[0].values, [SettingValue::Text("8x8x4".to_owned())]);
    assert_eq!(experiment.pipeline.filters, [Filter::Linear]);
    let VolumeSource::File { files, .. } = &experiment.volumes[0].source else { panic!("a file") };
    assert_eq!(files[0].written(), "/a=b/$X.nrrd");
}

#[test]
fn an_override_keeps_the_place_of_the_key_it_replaces() {
    let experiment = read(EXAMPLE, &["codec.s3dc.block=[16, 4]"]).unwrap();
    let names: Vec<&str> = experiment.codecs[1].sweeps.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["block", "index_bits"]);
}

#[test]
fn a_mistake_in_an_override_points_at_the_override() {
    let errors: Vec<String> = [
        "scene.step_voxels=-1",
        "scene.stepp_voxels=1",
        "scene.frnt.step_voxels=1",
        "codec.s3dc.blocks=8",
        "pipeline.filter=[\"linear\", cubic]",
        "codec.tape.x=1",
        "scene",
        "scene=1",
        "a b=1",
        "experiment.name.x=1",
        "volume.bonsai.\u{1b}=1",
        "=1",
    ]
    .iter()
    .map(|set| read(EXAMPLE, &[set]).unwrap_err())
    .collect();
    insta::assert_snapshot!(errors.join("\n\n"), @r#"
    error: expected a step from 0.01 to 1000 voxels, found `-1`
      ┌─ --set:1:19
      │
    1 │ scene.step_voxels=-1
      │                   ^^ expected a step from 0.01 to 1000 voxels

    error: the scene has no key `stepp_voxels`
      ┌─ --set:1:7
      │
    1 │ scene.stepp_voxels=1
      │       ^^^^^^^^^^^^ unknown key
      │
      = did you mean `step_voxels`?
      = known keys: name, volumes, size, camera, transfer_function, transfer_function_domain, opacity, frame, shading, clip_box, step_voxels, early_termination, background

    error: no scene is called `frnt`
      ┌─ --set:1:7
      │
    1 │ scene.frnt.step_voxels=1
      │       ^^^^ unknown scene
      │
      = did you mean `front`?
      = known scenes: front

    error: codec `s3dc` has no setting `blocks`
      ┌─ --set:1:12
      │
    1 │ codec.s3dc.blocks=8
      │            ^^^^^^ unknown setting
      │
      = did you mean `block`?
      = known settings: block, index_bits

    error: this is no TOML: string values must be quoted, expected literal string
      ┌─ --set:1:28
      │
    1 │ pipeline.filter=["linear", cubic]
      │                            ^^^^^

    error: no codec is called `tape`
      ┌─ --set:1:7
      │
    1 │ codec.tape.x=1
      │       ^^^^ unknown codec
      │
      = known codecs: raw, s3dc

    error: an override needs a key and a value
      ┌─ --set:1:1
      │
    1 │ scene
      │ ^^^^^ no `=`
      │
      = write, for instance, `--set scene.step_voxels=1.0`

    error: `scene` is a list of tables: which key of theirs is meant?
      ┌─ --set:1:1
      │
    1 │ scene=1
      │ ^^^^^ no key follows
      │
      = write `scene.KEY=VALUE`, or `scene.NAME.KEY=VALUE`

    error: an override begins with a dotted key
      ┌─ --set:1:1
      │
    1 │ a b=1
      │ ^^^ this is none
      │
      = write, for instance, `--set scene.step_voxels=1.0`

    error: `x` cannot be set: what holds it is a string, not a table
      ┌─ --set:1:17
      │
    1 │ experiment.name.x=1
      │                 ^ no such key
      │
      ┌─ x.toml:2:8
      │
    2 │ name = "compare"
      │        --------- a string stands here

    error: an override begins with a dotted key
      ┌─ --set:1:1
      │
    1 │ volume.bonsai.?=1
      │ ^^^^^^^^^^^^^^^ this is none
      │
      = write, for instance, `--set scene.step_voxels=1.0`

    error: an override begins with a dotted key
      ┌─ --set:1:1
      │
    1 │ =1
      │ ^ this is none
      │
      = write, for instance, `--set scene.step_voxels=1.0`
    "#);
}
