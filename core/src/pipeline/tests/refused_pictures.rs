//! The text of every error about the pipeline and scenes.

use super::*;

#[test]
fn pipelines() {
    let text = errors(&[
        ("filter = [\"nearest\", \"linear\"]", "filter = [\"nearest\", \"lineer\"]"),
        ("site = [\"inline\", \"host\"]", "site = \"remote\""),
        ("renderer = [\"raycasting\"]", "renderer = [\"raycast\"]"),
        ("renderer = [\"raycasting\"]", "renderer = []"),
        ("renderer = [\"raycasting\"]", ""),
        ("filter = [\"nearest\", \"linear\"]", "filter = [\"linear\", \"nearest\", \"linear\"]"),
        ("filter = [\"nearest\", \"linear\"]", "filter = 3"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: no filter is called `lineer`
       ┌─ x.toml:19:22
       │
    19 │ filter = ["nearest", "lineer"]
       │                      ^^^^^^^^ unknown filter
       │
       = did you mean `linear`?
       = known filters: nearest, linear, optimised-linear

    error: no site is called `remote`
       ┌─ x.toml:18:8
       │
    18 │ site = "remote"
       │        ^^^^^^^^ unknown site
       │
       = known sites: inline, deferred, ring, host

    error: no renderer is called `raycast`
       ┌─ x.toml:17:13
       │
    17 │ renderer = ["raycast"]
       │             ^^^^^^^^^ unknown renderer
       │
       = did you mean `raycasting`?
       = known renderers: raycasting, slicing

    error: the list names no renderer
       ┌─ x.toml:17:12
       │
    17 │ renderer = []
       │            ^^ empty list
       │
       = name at least one renderer

    error: the pipeline has no `renderer`
       ┌─ x.toml:16:1
       │
    16 │ [pipeline]                          # the product of all of these, minus refused pairs (with the reason in the report)
       │ ^^^^^^^^^^ missing here
       │
       = write, for instance, `renderer = ["raycasting"]`

    error: filter `linear` is listed twice
       ┌─ x.toml:19:32
       │
    19 │ filter = ["linear", "nearest", "linear"]
       │           --------             ^^^^^^^^ again
       │           │
       │           first
       │
       = each would be drawn once: remove one of the two

    error: expected a string, found an integer
       ┌─ x.toml:19:10
       │
    19 │ filter = 3
       │          ^ expected a string
    "#);
}

#[test]
fn settings_of_renderers() {
    const LINE: &str = "renderer = [\"raycasting\"]";
    let text = errors(&[
        (LINE, "renderer = \"slicing\"\ngeometry = \"shell\""),
        (LINE, "renderer = \"slicing\"\nlayers = [1, 10]"),
        (LINE, "renderer = \"slicing\"\ngeometry = []"),
        (LINE, "renderer = [\"raycasting\", \"slicing\"]\ngeometri = \"axis\""),
        (LINE, "renderer = \"raycasting\"\ngeometry = \"axis\""),
        (LINE, "renderer = \"slicin\"\ngeometry = \"axis\""),
        (LINE, "geometry = \"axis\""),
        (LINE, "renderer = \"raycasting\"\nskipping = \"yes\""),
        (LINE, "renderer = \"raycasting\"\nskipping = [true, false, true]"),
        (LINE, "renderer = \"raycasting\"\nskipping = []"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: `geometry` of renderer `slicing` cannot be `"shell"`
       ┌─ x.toml:18:12
       │
    18 │ geometry = "shell"
       │            ^^^^^^^ expected "planes", "axis" or "shells"
       │
       = geometry: where slices lie
       = a list is a sweep: each of its values is tried

    error: `layers` of renderer `slicing` cannot be `10`
       ┌─ x.toml:18:14
       │
    18 │ layers = [1, 10]
       │              ^^ expected an integer from 1 to 9
       │
       = layers: slices at once
       = a list is a sweep: each of its values is tried

    error: `geometry` lists no value to try
       ┌─ x.toml:18:12
       │
    18 │ geometry = []
       │            ^^ empty list
       │
       = leave the line away for the default, planes

    error: the pipeline has no key `geometri`
       ┌─ x.toml:18:1
       │
    18 │ geometri = "axis"
       │ ^^^^^^^^ unknown key
       │
       = did you mean `geometry`?
       = known keys: renderer, site, filter, skipping, stages, resolution, geometry, layers

    error: the pipeline has no key `geometry`
       ┌─ x.toml:18:1
       │
    18 │ geometry = "axis"
       │ ^^^^^^^^ unknown key
       │
       = known keys: renderer, site, filter, skipping, stages, resolution
       = renderer `slicing` has it, and is not named in `renderer`

    error: no renderer is called `slicin`
       ┌─ x.toml:17:12
       │
    17 │ renderer = "slicin"
       │            ^^^^^^^^ unknown renderer
       │
       = did you mean `slicing`?
       = known renderers: raycasting, slicing

    error: the pipeline has no `renderer`
       ┌─ x.toml:16:1
       │
    16 │ [pipeline]                          # the product of all of these, minus refused pairs (with the reason in the report)
       │ ^^^^^^^^^^ missing here
       │
       = write, for instance, `renderer = ["raycasting"]`

    error: expected true or false, found a string
       ┌─ x.toml:18:12
       │
    18 │ skipping = "yes"
       │            ^^^^^ expected true or false

    error: value of skipping `true` is listed twice
       ┌─ x.toml:18:26
       │
    18 │ skipping = [true, false, true]
       │             ----         ^^^^ again
       │             │
       │             first
       │
       = each would be drawn once: remove one of the two

    error: the list names no value of skipping
       ┌─ x.toml:18:12
       │
    18 │ skipping = []
       │            ^^ empty list
       │
       = name at least one value of skipping
    "#);
}

#[test]
fn scenes() {
    let text = errors(&[
        ("size = [256, 256]", "size = [256, 0]"),
        ("size = [256, 256]", "size = [8193, 256]"),
        ("size = [256, 256]", "size = 256"),
        ("step_voxels = 0.5", "step_voxels = 0"),
        ("step_voxels = 0.5", "step_voxels = nan"),
        ("step_voxels = 0.5", "step_voxels = \"0.5\""),
        ("step_voxels = 0.5", "early_termination = 1.5"),
        ("step_voxels = 0.5", "background = \"#00000000\""),
        ("step_voxels = 0.5", "volumes = [\"bonsay\"]"),
        ("step_voxels = 0.5", "volumes = []"),
        ("step_voxels = 0.5", "transfer_function_domain = \"range\""),
        ("elevation = 20.0", "elevation = 91"),
        ("projection = \"perspective\"", "projection = \"parallel\""),
        ("[60.0, \"#3d7a2a20\"]", "[30.0, \"#3d7a2a20\"]"),
        ("[60.0, \"#3d7a2a20\"]", "[60.0, \"#3d7a2\"]"),
        ("[60.0, \"#3d7a2a20\"]", "[60.0, \"#3d7aé2\"]"),
        ("[60.0, \"#3d7a2a20\"]", "[60.0, 7]"),
        ("[60.0, \"#3d7a2a20\"]", "[60.0]"),
        ("[60.0, \"#3d7a2a20\"]", "60.0"),
        ("[60.0, \"#3d7a2a20\"]", "[1e39, \"#3d7a2a20\"]"),
    ]);
    insta::assert_snapshot!(text, @r##"
    error: expected a number of pixels from 1 to 8192, found `0`
       ┌─ x.toml:23:14
       │
    23 │ size = [256, 0]
       │              ^ expected a number of pixels from 1 to 8192

    error: expected a number of pixels from 1 to 8192, found `8193`
       ┌─ x.toml:23:9
       │
    23 │ size = [8193, 256]
       │         ^^^^ expected a number of pixels from 1 to 8192

    error: expected width and height in pixels, found an integer
       ┌─ x.toml:23:8
       │
    23 │ size = 256
       │        ^^^ expected width and height in pixels

    error: expected a step from 0.01 to 1000 voxels, found `0`
       ┌─ x.toml:26:15
       │
    26 │ step_voxels = 0
       │               ^ expected a step from 0.01 to 1000 voxels

    error: expected a step from 0.01 to 1000 voxels, found `nan`
       ┌─ x.toml:26:15
       │
    26 │ step_voxels = nan
       │               ^^^ expected a step from 0.01 to 1000 voxels

    error: expected a step from 0.01 to 1000 voxels, found a string
       ┌─ x.toml:26:15
       │
    26 │ step_voxels = "0.5"
       │               ^^^^^ expected a step from 0.01 to 1000 voxels

    error: expected an opacity above 0 and at most 1, found `1.5`
       ┌─ x.toml:26:21
       │
    26 │ early_termination = 1.5
       │                     ^^^ expected an opacity above 0 and at most 1
       │
       = 1 = every ray runs to its end

    error: a background is opaque
       ┌─ x.toml:26:14
       │
    26 │ background = "#00000000"
       │              ^^^^^^^^^^^ has an opacity
       │
       = write a colour of six digits, "#rrggbb"

    error: no volume is called `bonsay`
       ┌─ x.toml:26:12
       │
    26 │ volumes = ["bonsay"]
       │            ^^^^^^^^ unknown volume
       │
       = did you mean `bonsai`?
       = known volumes: bonsai

    error: no scene applies to volume `bonsai`
      ┌─ x.toml:5:1
      │
    5 │ [[volume]]
      │ ^^^^^^^^^^ never drawn
      │
      = add a `[[scene]]` without `volumes`, or name the volume in one

    error: the list names no volume
       ┌─ x.toml:26:11
       │
    26 │ volumes = []
       │           ^^ empty list
       │
       = name at least one volume

    error: expected a value from 0 to 1, found `40.0`
       ┌─ x.toml:25:23
       │
    25 │ transfer_function = [[40.0, "#00000000"], [60.0, "#3d7a2a20"], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                       ^^^^ expected a value from 0 to 1
       │
       = in the domain "range", 0 is the volume's lowest value and 1 its highest

    error: expected an angle from -90 to 90 degrees, found `91`
       ┌─ x.toml:24:40
       │
    24 │ camera = { azimuth = 30.0, elevation = 91, zoom = 1.0, projection = "perspective" }   # degrees; zoom 1 fits the volume
       │                                        ^^ expected an angle from -90 to 90 degrees

    error: no projection is called `parallel`
       ┌─ x.toml:24:71
       │
    24 │ camera = { azimuth = 30.0, elevation = 20.0, zoom = 1.0, projection = "parallel" }   # degrees; zoom 1 fits the volume
       │                                                                       ^^^^^^^^^^ unknown projection
       │
       = known projections: perspective, orthographic

    error: control points are out of order
       ┌─ x.toml:25:44
       │
    25 │ transfer_function = [[40.0, "#00000000"], [30.0, "#3d7a2a20"], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                       ----                 ^^^^ below the value before it
       │                       │
       │                       the value before
       │
       = sort the points by value; two points of one value make a step

    error: expected a colour, "#rrggbb" or "#rrggbbaa", found `"#3d7a2"`
       ┌─ x.toml:25:50
       │
    25 │ transfer_function = [[40.0, "#00000000"], [60.0, "#3d7a2"], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                                  ^^^^^^^^ expected a colour, "#rrggbb" or "#rrggbbaa"

    error: expected a colour, "#rrggbb" or "#rrggbbaa", found `"#3d7aé2"`
       ┌─ x.toml:25:50
       │
    25 │ transfer_function = [[40.0, "#00000000"], [60.0, "#3d7aé2"], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                                  ^^^^^^^^^ expected a colour, "#rrggbb" or "#rrggbbaa"

    error: expected a colour, "#rrggbb" or "#rrggbbaa", found an integer
       ┌─ x.toml:25:50
       │
    25 │ transfer_function = [[40.0, "#00000000"], [60.0, 7], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                                  ^ expected a colour, "#rrggbb" or "#rrggbbaa"

    error: expected a control point, [value, "#rrggbbaa"], found a list of 1
       ┌─ x.toml:25:43
       │
    25 │ transfer_function = [[40.0, "#00000000"], [60.0], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                           ^^^^^^ expected a control point, [value, "#rrggbbaa"]

    error: expected a control point, [value, "#rrggbbaa"], found a float
       ┌─ x.toml:25:43
       │
    25 │ transfer_function = [[40.0, "#00000000"], 60.0, [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                           ^^^^ expected a control point, [value, "#rrggbbaa"]

    error: expected a data value, found `1e39`
       ┌─ x.toml:25:44
       │
    25 │ transfer_function = [[40.0, "#00000000"], [1e39, "#3d7a2a20"], [120.0, "#c8a060c0"], [255.0, "#ffffffff"]]   # data value, RGBA
       │                                            ^^^^ expected a data value
    "##);
    let function = EXAMPLE.lines().find(|l| l.starts_with("transfer_function")).unwrap();
    let text = errors(&[
        (function, ""),
        (function, "transfer_function = [[1, \"#000000\"]]"),
        (function, "transfer_function = [[1, \"#000000\"], [1, \"#ffffff\"]]"),
    ]);
    insta::assert_snapshot!(text, @r##"
    error: scene `front` has no `transfer_function`
       ┌─ x.toml:21:1
       │
    21 │ [[scene]]
       │ ^^^^^^^^^ missing here
       │
       = write, for instance, `transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]`

    error: a transfer function needs two control points, this has 1
       ┌─ x.toml:25:21
       │
    25 │ transfer_function = [[1, "#000000"]]
       │                     ^^^^^^^^^^^^^^^^ too few
       │
       = write, for instance, [[0, "#00000000"], [255, "#ffffffff"]]

    error: all control points lie at one value
       ┌─ x.toml:25:21
       │
    25 │ transfer_function = [[1, "#000000"], [1, "#ffffff"]]
       │                     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ no two values differ
       │
       = spread the points over several values
    "##);
}

#[test]
fn a_volume_that_no_scene_draws() {
    let text =
        edited("[[codec]]\nid = \"raw\"", "[[volume]]\nname = \"b\"\nfile = \"b\"\n[[codec]]\nid = \"raw\"");
    let text = text.replace("step_voxels = 0.5", "volumes = [\"bonsai\"]");
    insta::assert_snapshot!(read(&text, &[]).unwrap_err(), @r#"
    error: no scene applies to volume `b`
      ┌─ x.toml:9:1
      │
    9 │ [[volume]]
      │ ^^^^^^^^^^ never drawn
      │
      = add a `[[scene]]` without `volumes`, or name the volume in one
    "#);
}

#[test]
fn a_transfer_function_of_too_many_points() {
    let function = EXAMPLE.lines().find(|l| l.starts_with("transfer_function")).unwrap();
    let points = |n: u32| {
        let points: Vec<_> = (0..n).map(|i| format!("[{i}, \"#00000000\"],\n")).collect();
        format!("transfer_function = [\n{}]", points.concat())
    };
    read(&EXAMPLE.replace(function, &points(4096)), &[]).unwrap();
    insta::assert_snapshot!(errors(&[(function, &points(4098))]), @r##"
    error: a transfer function has at most 4096 control points, this has 4098
         ┌─ x.toml:4122:1
         │
    4122 │ [4096, "#00000000"],
         │ ^^^^^^^^^^^^^^^^^^^ one too many
         │
         = leave out points that lie on the line between their neighbours
    "##);
}
