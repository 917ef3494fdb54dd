//! Shading, clip box, opacity of colours, frames and named transfer functions: accepted values, and the text of every
//! error.

use super::*;
use std::sync::Arc;

use crate::pipeline::{FrameRange, Scene, SceneError, SceneOpacity, TransferDomain};
use crate::render::{ClipBox, ColourOpacity, Filter, Light, OpacityTable, Preset, Shading};
use crate::volume::ValueRange;

/// The scene of the example, with these lines instead of its step.
fn scene(lines: &str) -> Scene {
    read(&edited("step_voxels = 0.5", lines), &[]).unwrap_or_else(|e| panic!("{e}")).scenes.remove(0)
}

/// The line of the example that holds its transfer function.
fn function() -> &'static str {
    EXAMPLE.lines().find(|l| l.starts_with("transfer_function")).unwrap()
}

#[test]
fn a_scene_is_unlit_and_whole_unless_it_says_otherwise() {
    let plain = scene("");
    assert_eq!((plain.shading, plain.clip), (None, None));
    assert_eq!(scene("shading = false\nclip_box = [[0, 0, 0], [1, 1, 1.0]]"), plain);
}

#[test]
fn shading_is_read_with_its_defaults() {
    assert_eq!(scene("shading = true").shading, Some(Shading::default()));
    assert_eq!(scene("shading = {}").shading, Some(Shading::default()));
    let expected = Shading { ambient: 0.0, shininess: 1.0, ..Shading::default() };
    assert_eq!(scene("shading = { ambient = 0, shininess = 1 }").shading, Some(expected));
    let all = "[scene.shading]\nambient = 0.5\ndiffuse = 1\nspecular = 0.125\nshininess = 1000\nlight = 'fixed'\n\
               direction = [0, -2, 1e-30]";
    let expected = Shading {
        ambient: 0.5,
        diffuse: 1.0,
        specular: 0.125,
        shininess: 1000.0,
        light: Light::Fixed,
        direction: [0.0, -2.0, 1e-30],
    };
    assert_eq!(scene(all).shading, Some(expected));
    let experiment = read(EXAMPLE, &["scene.shading=true", "scene.clip_box=[[0,0,0],[1,1,0.5]]"]).unwrap();
    assert_eq!(experiment.scenes[0].shading, Some(Shading::default()));
    assert_eq!(experiment.scenes[0].clip.map(|clip| clip.high), Some([1.0, 1.0, 0.5]));
}

#[test]
fn optics_reach_the_view() {
    let scene = scene("shading = { light = 'fixed' }\nclip_box = [[0, 0.25, 0.5], [1, 0.75, 0.625]]");
    let view = scene.view(ValueRange { min: 0.0, max: 255.0 }, Filter::Linear).unwrap();
    assert_eq!(view.shading, Some(Shading { light: Light::Fixed, ..Shading::default() }));
    assert_eq!(view.clip, Some(ClipBox { low: [0.0, 0.25, 0.5], high: [1.0, 0.75, 0.625] }));
}

#[test]
fn what_decides_the_opacity_of_colours_reaches_the_view_once_it_is_read() {
    let range = ValueRange { min: 0.0, max: 255.0 };
    let opacity = |scene: &Scene| scene.view(range, Filter::Linear).map(|view| view.colour_opacity);
    assert_eq!(opacity(&scene("")), Ok(ColourOpacity::Luminance));
    assert_eq!(scene("opacity = \"luminance\""), scene(""));
    assert_eq!(opacity(&scene("opacity = \"blue\"")), Ok(ColourOpacity::Channel(2)));
    let mut from_file = scene("opacity = { table = \"$TABLES/a.npy\" }");
    assert_eq!(opacity(&from_file), Err(SceneError::Table("$TABLES/a.npy".to_owned())));
    let table = ColourOpacity::Table(Arc::new(OpacityTable::new(2, &[0.5; 8]).unwrap()));
    from_file.opacity = SceneOpacity::Known(table.clone());
    assert_eq!(opacity(&from_file), Ok(table));
}

#[test]
fn a_frame_or_a_range_is_drawn() {
    assert_eq!(scene("").frames, FrameRange { first: 0, last: 0 });
    assert_eq!(scene("frame = 7").frames, FrameRange { first: 7, last: 7 });
    let range = scene("frame = [2, 4]").frames;
    assert_eq!(range.iter().map(|frame| frame.0).collect::<Vec<_>>(), [2, 3, 4]);
    assert_eq!(
        (range.to_string(), scene("frame = 7").frames.to_string()),
        ("frames 2 to 4".into(), "frame 7".into())
    );
}

#[test]
fn wrong_opacities_and_frames() {
    let text = errors(&[
        ("step_voxels = 0.5", "opacity = \"lumiance\""),
        ("step_voxels = 0.5", "opacity = 0.5"),
        ("step_voxels = 0.5", "opacity = {}"),
        ("step_voxels = 0.5", "opacity = { table = \"\" }"),
        ("step_voxels = 0.5", "opacity = { file = \"a.npy\" }"),
        ("step_voxels = 0.5", "frame = -1"),
        ("step_voxels = 0.5", "frame = 1.5"),
        ("step_voxels = 0.5", "frame = [1, 2, 3]"),
        ("step_voxels = 0.5", "frame = [4, 2]"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: no channel is called `lumiance`
       ┌─ x.toml:26:11
       │
    26 │ opacity = "lumiance"
       │           ^^^^^^^^^^ unknown channel
       │
       = did you mean `luminance`?
       = known channels: luminance, red, green, blue
       = a table over all colours is { table = "file.npy" }

    error: expected "luminance", a channel, or { table = "file.npy" }, found a float
       ┌─ x.toml:26:11
       │
    26 │ opacity = 0.5
       │           ^^^ expected "luminance", a channel, or { table = "file.npy" }

    error: the opacity has no `table`
       ┌─ x.toml:26:11
       │
    26 │ opacity = {}
       │           ^^ missing here
       │
       = write, for instance, `table = "file.npy"`

    error: the path is empty
       ┌─ x.toml:26:21
       │
    26 │ opacity = { table = "" }
       │                     ^^ not a path
       │
       = `$NAME` and `${NAME}` stand for environment variables, `$$` for `$`

    error: the opacity has no key `file`
       ┌─ x.toml:26:13
       │
    26 │ opacity = { file = "a.npy" }
       │             ^^^^ unknown key
       │
       = known keys: table

    error: expected a number of a frame, counted from 0, found `-1`
       ┌─ x.toml:26:9
       │
    26 │ frame = -1
       │         ^^ expected a number of a frame, counted from 0
       │
       = a range is written [first, last]

    error: expected a number of a frame, counted from 0, found a float
       ┌─ x.toml:26:9
       │
    26 │ frame = 1.5
       │         ^^^ expected a number of a frame, counted from 0
       │
       = a range is written [first, last]

    error: expected the first and the last frame, found a list of 3
       ┌─ x.toml:26:9
       │
    26 │ frame = [1, 2, 3]
       │         ^^^^^^^^^ expected the first and the last frame

    error: a range of frames runs forwards
       ┌─ x.toml:26:9
       │
    26 │ frame = [4, 2]
       │         ^^^^^^ the last frame comes before the first
    "#);
}

#[test]
fn every_preset_has_a_name_in_a_configuration() {
    for preset in Preset::ALL {
        for domain in ["", "\ntransfer_function_domain = \"range\""] {
            let text = edited(function(), &format!("transfer_function = \"{}\"{domain}", preset.name));
            let scene = read(&text, &[]).unwrap_or_else(|e| panic!("{e}")).scenes.remove(0);
            assert_eq!(
                (&scene.control_points, scene.domain),
                (&preset.control_points(), TransferDomain::Range)
            );
            let function = scene.transfer_function(ValueRange { min: -5.0, max: 15.0 }).unwrap();
            assert_eq!(function.domain(), ValueRange { min: -5.0, max: 15.0 });
        }
    }
    let overridden = read(EXAMPLE, &["scene.front.transfer_function=heat"]).unwrap();
    assert_eq!(overridden.scenes[0].domain, TransferDomain::Range);
}

#[test]
fn wrong_shadings() {
    let text = errors(&[
        ("step_voxels = 0.5", "shading = \"phong\""),
        ("step_voxels = 0.5", "shading = 1"),
        ("step_voxels = 0.5", "shading = { ambeint = 0.5 }"),
        ("step_voxels = 0.5", "shading = { ambient = 1.5 }"),
        ("step_voxels = 0.5", "shading = { diffuse = nan }"),
        ("step_voxels = 0.5", "shading = { specular = true }"),
        ("step_voxels = 0.5", "shading = { shininess = 0 }"),
        ("step_voxels = 0.5", "shading = { light = \"camra\" }"),
        ("step_voxels = 0.5", "shading = { direction = [0, -0.0, 0] }"),
        ("step_voxels = 0.5", "shading = { direction = [0, 1e-60, 0] }"),
        ("step_voxels = 0.5", "shading = { direction = [0, 1] }"),
        ("step_voxels = 0.5", "shading = { direction = [0, 1e39, 0] }"),
        ("step_voxels = 0.5", "shading = { direction = \"up\" }"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: expected true, false or a table, found a string
       ┌─ x.toml:26:11
       │
    26 │ shading = "phong"
       │           ^^^^^^^ expected true, false or a table
       │
       = write, for instance, { ambient = 0.3, light = "fixed", direction = [1, -1, 2] }

    error: expected true, false or a table, found an integer
       ┌─ x.toml:26:11
       │
    26 │ shading = 1
       │           ^ expected true, false or a table
       │
       = write, for instance, { ambient = 0.3, light = "fixed", direction = [1, -1, 2] }

    error: the shading has no key `ambeint`
       ┌─ x.toml:26:13
       │
    26 │ shading = { ambeint = 0.5 }
       │             ^^^^^^^ unknown key
       │
       = did you mean `ambient`?
       = known keys: ambient, diffuse, specular, shininess, light, direction

    error: expected a share from 0 to 1, found `1.5`
       ┌─ x.toml:26:23
       │
    26 │ shading = { ambient = 1.5 }
       │                       ^^^ expected a share from 0 to 1

    error: expected a share from 0 to 1, found `nan`
       ┌─ x.toml:26:23
       │
    26 │ shading = { diffuse = nan }
       │                       ^^^ expected a share from 0 to 1

    error: expected a share from 0 to 1, found a boolean
       ┌─ x.toml:26:24
       │
    26 │ shading = { specular = true }
       │                        ^^^^ expected a share from 0 to 1

    error: expected an exponent from 1 to 1000, found `0`
       ┌─ x.toml:26:25
       │
    26 │ shading = { shininess = 0 }
       │                         ^ expected an exponent from 1 to 1000
       │
       = the larger, the smaller the highlight

    error: no light is called `camra`
       ┌─ x.toml:26:21
       │
    26 │ shading = { light = "camra" }
       │                     ^^^^^^^ unknown light
       │
       = did you mean `camera`?
       = known lights: camera, fixed

    error: light comes from no direction
       ┌─ x.toml:26:25
       │
    26 │ shading = { direction = [0, -0.0, 0] }
       │                         ^^^^^^^^^^^^ of no length
       │
       = [x, y, z] points towards the light, as far as you like: [-0.4, 0.6, 1]
       = x, y, z are right, up, towards the viewer; with light = "fixed", the volume's axes

    error: light comes from no direction
       ┌─ x.toml:26:25
       │
    26 │ shading = { direction = [0, 1e-60, 0] }
       │                         ^^^^^^^^^^^^^ of no length
       │
       = [x, y, z] points towards the light, as far as you like: [-0.4, 0.6, 1]
       = x, y, z are right, up, towards the viewer; with light = "fixed", the volume's axes

    error: expected a direction, [x, y, z], found a list of 2
       ┌─ x.toml:26:25
       │
    26 │ shading = { direction = [0, 1] }
       │                         ^^^^^^ expected a direction, [x, y, z]

    error: expected a number, found `1e39`
       ┌─ x.toml:26:29
       │
    26 │ shading = { direction = [0, 1e39, 0] }
       │                             ^^^^ expected a number

    error: expected a direction, [x, y, z], found a string
       ┌─ x.toml:26:25
       │
    26 │ shading = { direction = "up" }
       │                         ^^^^ expected a direction, [x, y, z]
    "#);
}

#[test]
fn wrong_clip_boxes() {
    let text = errors(&[
        ("step_voxels = 0.5", "clip_box = 0.5"),
        ("step_voxels = 0.5", "clip_box = [0, 0, 0, 1, 1, 1]"),
        ("step_voxels = 0.5", "clip_box = [[0, 0], [1, 1]]"),
        ("step_voxels = 0.5", "clip_box = [[0, 0, 0], [1, 1, 64]]"),
        ("step_voxels = 0.5", "clip_box = [[0, -0.1, 0], [1, 1, 1]]"),
        ("step_voxels = 0.5", "clip_box = [[0, 0.5, 0], [1, 0.25, 1]]"),
        ("step_voxels = 0.5", "clip_box = [[0, 0, 0.1], [1, 1, 0.1000000001]]"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: expected two corners, [[x, y, z], [x, y, z]], found a float
       ┌─ x.toml:26:12
       │
    26 │ clip_box = 0.5
       │            ^^^ expected two corners, [[x, y, z], [x, y, z]]

    error: expected two corners, [[x, y, z], [x, y, z]], found a list of 6
       ┌─ x.toml:26:12
       │
    26 │ clip_box = [0, 0, 0, 1, 1, 1]
       │            ^^^^^^^^^^^^^^^^^^ expected two corners, [[x, y, z], [x, y, z]]

    error: expected a corner, [x, y, z], found a list of 2
       ┌─ x.toml:26:13
       │
    26 │ clip_box = [[0, 0], [1, 1]]
       │             ^^^^^^ expected a corner, [x, y, z]

    error: expected a share of the volume's extent from 0 to 1, found `64`
       ┌─ x.toml:26:31
       │
    26 │ clip_box = [[0, 0, 0], [1, 1, 64]]
       │                               ^^ expected a share of the volume's extent from 0 to 1
       │
       = 0 is the volume's lower face, 1 its upper one

    error: expected a share of the volume's extent from 0 to 1, found `-0.1`
       ┌─ x.toml:26:17
       │
    26 │ clip_box = [[0, -0.1, 0], [1, 1, 1]]
       │                 ^^^^ expected a share of the volume's extent from 0 to 1
       │
       = 0 is the volume's lower face, 1 its upper one

    error: the clip box is empty along y
       ┌─ x.toml:26:30
       │
    26 │ clip_box = [[0, 0.5, 0], [1, 0.25, 1]]
       │                 ---          ^^^^ not above the lower corner
       │                 │
       │                 the lower corner
       │
       = write the lower corner first; the whole volume is [[0, 0, 0], [1, 1, 1]]

    error: the clip box is empty along z
       ┌─ x.toml:26:33
       │
    26 │ clip_box = [[0, 0, 0.1], [1, 1, 0.1000000001]]
       │                    ---          ^^^^^^^^^^^^ not above the lower corner
       │                    │
       │                    the lower corner
       │
       = write the lower corner first; the whole volume is [[0, 0, 0], [1, 1, 1]]
    "#);
}

#[test]
fn wrong_presets() {
    let text = errors(&[
        (function(), "transfer_function = \"tisue\""),
        (function(), "transfer_function = \"\""),
        (function(), "transfer_function = \"tissue\"\ntransfer_function_domain = \"data\""),
        (function(), "transfer_function = 3"),
    ]);
    insta::assert_snapshot!(text, @r##"
    error: no preset is called `tisue`
       ┌─ x.toml:25:21
       │
    25 │ transfer_function = "tisue"
       │                     ^^^^^^^ unknown preset
       │
       = did you mean `tissue`?
       = known presets: ramp, surface, tissue, heat, signed

    error: no preset is called ``
       ┌─ x.toml:25:21
       │
    25 │ transfer_function = ""
       │                     ^^ unknown preset
       │
       = known presets: ramp, surface, tissue, heat, signed

    error: preset `tissue` lies over the range of the volume's values
       ┌─ x.toml:26:28
       │
    25 │ transfer_function = "tissue"
       │                     -------- the preset
    26 │ transfer_function_domain = "data"
       │                            ^^^^^^ and not over data values
       │
       = leave `transfer_function_domain` out, or write control points in data values

    error: expected a list of control points, [[value, "#rrggbbaa"], …], or the name of a preset, found an integer
       ┌─ x.toml:25:21
       │
    25 │ transfer_function = 3
       │                     ^ expected a list of control points, [[value, "#rrggbbaa"], …], or the name of a preset
    "##);
}
