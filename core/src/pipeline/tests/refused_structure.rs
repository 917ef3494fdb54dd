//! The text of every error about syntax, keys and tables.

use super::*;

#[test]
fn syntax() {
    let text = errors(&[
        ("seed = 1", "seed = "),
        ("seed = 1", "seed = 99999999999999999999"),
        ("seed = 1", "seed = 1\nseed = 2"),
        ("size = [256, 256]", "size = [256, 256"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: this is no TOML: string values must be quoted, expected literal string
      ┌─ x.toml:3:8
      │
    3 │ seed =
      │        ^

    error: the number is too large
      ┌─ x.toml:3:8
      │
    3 │ seed = 99999999999999999999
      │        ^^^^^^^^^^^^^^^^^^^^ exceeds 64 bits

    error: this is no TOML: duplicate key
      ┌─ x.toml:4:1
      │
    4 │ seed = 2
      │ ^^^^

    error: this is no TOML: missing comma between array elements, expected `,`
       ┌─ x.toml:24:1
       │
    24 │ camera = { azimuth = 30.0, elevation = 20.0, zoom = 1.0, projection = "perspective" }   # degrees; zoom 1 fits the volume
       │ ^
    "#);
}

#[test]
fn unknown_keys() {
    let text = errors(&[
        ("seed = 1", "sed = 1"),
        ("step_voxels", "stepvoxels"),
        ("azimuth", "azimut"),
        ("filter =", "filters ="),
        ("file =", "path ="),
        ("[pipeline]", "[pipelines]\n[pipeline]"),
        ("zoom = 1.0", "fov = 20"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: the experiment has no key `sed`
      ┌─ x.toml:3:1
      │
    3 │ sed = 1
      │ ^^^ unknown key
      │
      = did you mean `seed`?
      = known keys: name, seed, max_cells, decoded_frames_mb

    error: the scene has no key `stepvoxels`
       ┌─ x.toml:26:1
       │
    26 │ stepvoxels = 0.5
       │ ^^^^^^^^^^ unknown key
       │
       = did you mean `step_voxels`?
       = known keys: name, volumes, size, camera, transfer_function, transfer_function_domain, opacity, frame, shading, clip_box, step_voxels, early_termination, background

    error: the camera has no key `azimut`
       ┌─ x.toml:24:12
       │
    24 │ camera = { azimut = 30.0, elevation = 20.0, zoom = 1.0, projection = "perspective" }   # degrees; zoom 1 fits the volume
       │            ^^^^^^ unknown key
       │
       = did you mean `azimuth`?
       = known keys: azimuth, elevation, roll, zoom, projection, field_of_view

    error: the pipeline has no key `filters`
       ┌─ x.toml:19:1
       │
    19 │ filters = ["nearest", "linear"]
       │ ^^^^^^^ unknown key
       │
       = did you mean `filter`?
       = known keys: renderer, site, filter, skipping, stages, resolution

    error: the volume has no key `path`
      ┌─ x.toml:7:1
      │
    7 │ path = "$CVR_DATA/bonsai.nrrd"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │ ^^^^ unknown key
      │
      = known keys: name, file, files, generate, dims, dtype, frames, channels, byte_order, skip_bytes, spacing

    error: the configuration has no key `pipelines`
       ┌─ x.toml:16:2
       │
    16 │ [pipelines]
       │  ^^^^^^^^^ unknown key
       │
       = did you mean `pipeline`?
       = known keys: experiment, volume, codec, pipeline, scene

    error: the camera has no key `fov`
       ┌─ x.toml:24:46
       │
    24 │ camera = { azimuth = 30.0, elevation = 20.0, fov = 20, projection = "perspective" }   # degrees; zoom 1 fits the volume
       │                                              ^^^ unknown key
       │
       = known keys: azimuth, elevation, roll, zoom, projection, field_of_view
    "#);
}

#[test]
fn tables() {
    let text = errors(&[
        ("[experiment]\nname = \"compare\"\nseed = 1\n", ""),
        ("[[scene]]", "[scene]"),
        ("[pipeline]", "[[pipeline]]"),
        ("[[volume]]", "[[volumes]]"),
        ("name = \"front\"\n", ""),
        ("[experiment]\n", "experiment = 3\n[x]\n"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: the configuration has no `[experiment]`
      ┌─ x.toml:1:1
      │
    1 │
      │ ^ none in this file
      │
      = add, for instance,
        [experiment]
        name = "compare"

    error: `scene` is a list of tables, and this is a single one
       ┌─ x.toml:21:1
       │
    21 │ [scene]
       │ ^^^^^^^ single table
       │
       = write `[[scene]]`

    error: `pipeline` is a single table, and this is a list
       ┌─ x.toml:16:1
       │
    16 │ [[pipeline]]                          # the product of all of these, minus refused pairs (with the reason in the report)
       │ ^^^^^^^^^^^^ list of tables
       │
       = write `[pipeline]`

    error: the configuration has no key `volumes`
      ┌─ x.toml:5:3
      │
    5 │ [[volumes]]
      │   ^^^^^^^ unknown key
      │
      = did you mean `volume`?
      = known keys: experiment, volume, codec, pipeline, scene

    error: the configuration has no `[[volume]]`
      ┌─ x.toml:1:1
      │
    1 │ [experiment]
      │ ^ none in this file
      │
      = add, for instance,
        [[volume]]
        name = "bonsai"
        file = "$CVR_DATA/bonsai.nrrd"

    error: the scene has no `name`
       ┌─ x.toml:21:1
       │
    21 │ [[scene]]
       │ ^^^^^^^^^ missing here
       │
       = write, for instance, `name = "front"`

    error: the configuration has no key `x`
      ┌─ x.toml:2:2
      │
    2 │ [x]
      │  ^ unknown key
      │
      = known keys: experiment, volume, codec, pipeline, scene

    error: expected a table that describes the experiment, found an integer
      ┌─ x.toml:1:14
      │
    1 │ experiment = 3
      │              ^ expected a table that describes the experiment
    "#);
}

#[test]
fn every_table_reports_its_first_error() {
    let text = edited("seed = 1", "seed = -1").replace("size = [256, 256]", "size = []");
    let text = text.replace("site = [", "site = [1, ");
    let registry = registry();
    let errors = Document::parse("x.toml", &text).unwrap().experiment(&known(&registry)).unwrap_err();
    assert_eq!(errors.0.len(), 3, "{errors}");
}

/// A broken script may cause one error a thousand times.
#[test]
fn the_first_errors_are_shown_and_the_others_counted() {
    let shown =
        |tables: usize| read(&format!("{EXAMPLE}\n{}", "[[scene]]\n".repeat(tables)), &[]).unwrap_err();
    for (tables, more) in [(10, ""), (11, "\n\nand 1 error more"), (30, "\n\nand 20 errors more")] {
        let text = shown(tables);
        assert_eq!(text.matches("error: ").count(), 10, "{text}");
        assert!(text.ends_with(more) && (text.contains("more") != more.is_empty()), "{text}");
    }
}
