//! Cells, their order and names, and refusals.

use super::*;
use crate::codec::Site;
use crate::pipeline::{Capabilities, Cell, Reason, Resolution, resolve};

fn resolved(text: &str, overrides: &[&str], capabilities: &Capabilities) -> Resolution {
    let registry = registry();
    let experiment = read(text, overrides).unwrap_or_else(|e| panic!("{e}"));
    resolve(&experiment, &known(&registry), capabilities)
}

fn ids(resolution: &Resolution) -> String {
    resolution.cells.iter().map(Cell::id).collect::<Vec<_>>().join("\n")
}

fn reasons(resolution: &Resolution) -> String {
    let line = |r: &crate::pipeline::Refusal| format!("{}: {}", r.cell.id(), r.reason);
    resolution.refused.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn cells_follow_the_order_of_the_file() {
    let resolution = resolved(EXAMPLE, &["pipeline.site=inline"], &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-inline-nearest
    bonsai-raw-bits=native-front-raycasting-inline-linear
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-inline-nearest
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-inline-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-inline-nearest
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-inline-linear
    bonsai-s3dc-block=8,index_bits=2-front-raycasting-inline-nearest
    bonsai-s3dc-block=8,index_bits=2-front-raycasting-inline-linear
    bonsai-s3dc-block=8,index_bits=4-front-raycasting-inline-nearest
    bonsai-s3dc-block=8,index_bits=4-front-raycasting-inline-linear
    bonsai-s3dc-block=8x8x4,index_bits=2-front-raycasting-inline-nearest
    bonsai-s3dc-block=8x8x4,index_bits=2-front-raycasting-inline-linear
    bonsai-s3dc-block=8x8x4,index_bits=4-front-raycasting-inline-nearest
    bonsai-s3dc-block=8x8x4,index_bits=4-front-raycasting-inline-linear
    "#);
    assert_eq!(resolution.refused, []);
    let swapped =
        edited("index_bits = [2, 4]\n", "").replace("block = [4,", "index_bits = [4, 2]\nblock = [4,");
    let first = &resolved(&swapped, &["codec.s3dc.block=[4, 8]"], &Capabilities::default());
    let settings: Vec<String> = first.cells.iter().map(|c| c.settings.to_string()).collect();
    assert_eq!(
        settings.chunks(4).map(|c| c[0].as_str()).collect::<Vec<_>>(),
        [
            "bits=native",
            "block=4 index_bits=4",
            "block=8 index_bits=4",
            "block=4 index_bits=2",
            "block=8 index_bits=2"
        ]
    );
}

#[test]
fn skipping_and_settings_of_renderers_are_axes() {
    let set = [
        "pipeline.renderer=[\"raycasting\", \"slicing\"]",
        "pipeline.geometry=[\"planes\", \"axis\"]",
        "pipeline.skipping=[false, true]",
        "pipeline.site=host",
        "pipeline.filter=linear",
        "codec.s3dc.block=4",
        "codec.s3dc.index_bits=4",
    ];
    let resolution = resolved(EXAMPLE, &set, &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear
    bonsai-raw-bits=native-front-raycasting-host-linear-skipping
    bonsai-raw-bits=native-front-slicing-host-linear
    bonsai-raw-bits=native-front-slicing-host-linear-skipping
    bonsai-raw-bits=native-front-slicing,geometry=axis-host-linear
    bonsai-raw-bits=native-front-slicing,geometry=axis-host-linear-skipping
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-skipping
    bonsai-s3dc-block=4,index_bits=4-front-slicing-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-slicing-host-linear-skipping
    bonsai-s3dc-block=4,index_bits=4-front-slicing,geometry=axis-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-slicing,geometry=axis-host-linear-skipping
    "#);
    assert_eq!(resolution.refused, []);
    let off = resolved(EXAMPLE, &[&set[..2], &set[3..]].concat(), &Capabilities::default());
    let unskipped: Vec<Cell> = resolution.cells.into_iter().filter(|c| !c.skipping).collect();
    assert_eq!(off.cells, unskipped, "cells that do not skip are named as ever");
}

#[test]
fn every_refusal_has_its_reason() {
    let text = edited("id = \"raw\"", "id = \"raw\"\n[[codec]]\nid = \"tape\"");
    let set =
        ["codec.s3dc.block=[4, \"4x4x4\"]", "codec.s3dc.index_bits=4", "pipeline.filter=optimised-linear"];
    let resolution = resolved(&text, &set, &Capabilities::default());
    assert_eq!(ids(&resolution), "bonsai-s3dc-block=4,index_bits=4-front-raycasting-inline-optimised-linear");
    insta::assert_snapshot!(reasons(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-inline-optimised-linear: filter optimised-linear: codec raw has no fetch_cell (codecs that have one: s3dc); use filter linear
    bonsai-raw-bits=native-front-raycasting-host-optimised-linear: filter optimised-linear: site host filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-tape-front-raycasting-inline-optimised-linear: codec tape cannot be decoded at site inline; it offers: host
    bonsai-tape-front-raycasting-host-optimised-linear: filter optimised-linear: site host filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-optimised-linear: filter optimised-linear: site host filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    "#);
    let set = ["codec.s3dc.block=128", "codec.s3dc.index_bits=1", "pipeline.filter=linear"];
    let capabilities =
        Capabilities { missing_sites: vec![(Site::Host, "this device has no 3-D textures".to_owned())] };
    insta::assert_snapshot!(reasons(&resolved(EXAMPLE, &set, &capabilities)), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear: site host: this device has no 3-D textures
    bonsai-s3dc-block=128,index_bits=1-front-raycasting-inline-linear: a block of 128 needs 2 bits
    bonsai-s3dc-block=128,index_bits=1-front-raycasting-host-linear: a block of 128 needs 2 bits
    "#);
}

#[test]
fn deferred_comes_with_inline_and_never_calls_fetch_cell() {
    let text = edited("id = \"raw\"", "id = \"raw\"\n[[codec]]\nid = \"tape\"");
    let set = ["codec.s3dc.block=4", "codec.s3dc.index_bits=4", "pipeline.site=deferred"];
    let filters = "pipeline.filter=[\"linear\", \"optimised-linear\"]";
    let resolution = resolved(&text, &[&set[..], &[filters]].concat(), &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-deferred-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-deferred-linear
    "#);
    insta::assert_snapshot!(reasons(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-deferred-optimised-linear: filter optimised-linear: site deferred filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-tape-front-raycasting-deferred-linear: codec tape cannot be decoded at site deferred; it offers: host
    bonsai-tape-front-raycasting-deferred-optimised-linear: codec tape cannot be decoded at site deferred; it offers: host
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-deferred-optimised-linear: filter optimised-linear: site deferred filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    "#);
}

#[test]
fn a_ring_comes_with_inline_and_with_renderers_that_draw_layer_by_layer() {
    let text = edited("id = \"raw\"", "id = \"raw\"\n[[codec]]\nid = \"tape\"");
    let set = [
        "codec.s3dc.block=4",
        "codec.s3dc.index_bits=4",
        "pipeline.site=ring",
        "pipeline.renderer=[\"raycasting\", \"slicing\"]",
        "pipeline.geometry=[\"axis\", \"shells\"]",
        "pipeline.filter=[\"linear\", \"optimised-linear\"]",
    ];
    let resolution = resolved(&text, &set, &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-slicing,geometry=axis-ring-linear
    bonsai-s3dc-block=4,index_bits=4-front-slicing,geometry=axis-ring-linear
    "#);
    let of_raw = |line: &&str| line.contains("-raw-") || line.contains("-tape-");
    let reasons = reasons(&resolution);
    insta::assert_snapshot!(reasons.lines().filter(of_raw).collect::<Vec<_>>().join("\n"), @r#"
    bonsai-raw-bits=native-front-raycasting-ring-linear: site ring: renderer raycasting does not draw layer by layer; renderers that do: slicing,geometry=axis
    bonsai-raw-bits=native-front-raycasting-ring-optimised-linear: filter optimised-linear: site ring filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-raw-bits=native-front-slicing,geometry=axis-ring-optimised-linear: filter optimised-linear: site ring filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-raw-bits=native-front-slicing,geometry=shells-ring-linear: site ring: renderer slicing,geometry=shells does not draw layer by layer; renderers that do: slicing,geometry=axis
    bonsai-raw-bits=native-front-slicing,geometry=shells-ring-optimised-linear: filter optimised-linear: site ring filters decoded texels and never calls the codec's fetch_cell; use filter linear, or site inline
    bonsai-tape-front-raycasting-ring-linear: codec tape cannot be decoded at site ring; it offers: host
    bonsai-tape-front-raycasting-ring-optimised-linear: codec tape cannot be decoded at site ring; it offers: host
    bonsai-tape-front-slicing,geometry=axis-ring-linear: codec tape cannot be decoded at site ring; it offers: host
    bonsai-tape-front-slicing,geometry=axis-ring-optimised-linear: codec tape cannot be decoded at site ring; it offers: host
    bonsai-tape-front-slicing,geometry=shells-ring-linear: codec tape cannot be decoded at site ring; it offers: host
    bonsai-tape-front-slicing,geometry=shells-ring-optimised-linear: codec tape cannot be decoded at site ring; it offers: host
    "#);
}

#[test]
fn settings_decide_which_sites_a_codec_offers() {
    let set = [
        "codec.s3dc.block=[16, 32]",
        "codec.s3dc.index_bits=2",
        "pipeline.site=[\"inline\", \"deferred\", \"host\"]",
        "pipeline.filter=linear",
    ];
    let resolution = resolved(EXAMPLE, &set, &Capabilities::default());
    let of_s3dc = |text: String| -> String {
        text.lines().filter(|line| line.contains("-s3dc-")).collect::<Vec<_>>().join("\n")
    };
    insta::assert_snapshot!(of_s3dc(ids(&resolution)), @r#"
    bonsai-s3dc-block=16,index_bits=2-front-raycasting-inline-linear
    bonsai-s3dc-block=16,index_bits=2-front-raycasting-deferred-linear
    bonsai-s3dc-block=16,index_bits=2-front-raycasting-host-linear
    bonsai-s3dc-block=32,index_bits=2-front-raycasting-host-linear
    "#);
    insta::assert_snapshot!(of_s3dc(reasons(&resolution)), @r#"
    bonsai-s3dc-block=32,index_bits=2-front-raycasting-inline-linear: codec s3dc cannot be decoded at site inline; it offers: host
    bonsai-s3dc-block=32,index_bits=2-front-raycasting-deferred-linear: codec s3dc cannot be decoded at site deferred; it offers: host
    "#);
}

#[test]
fn stages_are_an_axis_of_codecs_that_have_them() {
    let set = ["pipeline.stages=[\"all\", 1, 3, 4]", "pipeline.site=host", "pipeline.filter=linear"];
    let resolution =
        resolved(EXAMPLE, &[&set[..], &["codec.s3dc.block=4"]].concat(), &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-stages=1
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-stages=3
    "#);
    insta::assert_snapshot!(reasons(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear-stages=1: stages 1: codec raw has no stages that could be left out; use stages "all"
    bonsai-raw-bits=native-front-raycasting-host-linear-stages=3: stages 3: codec raw has no stages that could be left out; use stages "all"
    bonsai-raw-bits=native-front-raycasting-host-linear-stages=4: stages 4: codec raw has no stages that could be left out; use stages "all"
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear-stages=1: stages 1: codec s3dc has no stages that could be left out; use stages "all"
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear-stages=3: stages 3: codec s3dc has no stages that could be left out; use stages "all"
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear-stages=4: stages 4: codec s3dc has no stages that could be left out; use stages "all"
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-stages=4: stages 4: codec s3dc has 3 stages; use 1 to 3, or "all"
    "#);
    let levels: Vec<u8> = resolution.cells.iter().map(|c| c.level().stages).collect();
    assert_eq!(levels, [255, 255, 255, 1, 3]);
}

#[test]
fn resolutions_are_an_axis_of_codecs_that_have_several() {
    let set = ["pipeline.resolution=[0, 1, 2]", "pipeline.site=host", "pipeline.filter=linear"];
    let resolution =
        resolved(EXAMPLE, &[&set[..], &["codec.s3dc.block=4"]].concat(), &Capabilities::default());
    insta::assert_snapshot!(ids(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-resolution=1
    "#);
    insta::assert_snapshot!(reasons(&resolution), @r#"
    bonsai-raw-bits=native-front-raycasting-host-linear-resolution=1: resolution 1: codec raw has the full resolution alone; use resolution 0
    bonsai-raw-bits=native-front-raycasting-host-linear-resolution=2: resolution 2: codec raw has the full resolution alone; use resolution 0
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear-resolution=1: resolution 1: codec s3dc has the full resolution alone; use resolution 0
    bonsai-s3dc-block=4,index_bits=2-front-raycasting-host-linear-resolution=2: resolution 2: codec s3dc has the full resolution alone; use resolution 0
    bonsai-s3dc-block=4,index_bits=4-front-raycasting-host-linear-resolution=2: resolution 2: codec s3dc has resolutions 0 to 1 with these settings
    "#);
    let levels: Vec<u8> = resolution.cells.iter().map(|c| c.level().resolution).collect();
    assert_eq!(levels, [0, 0, 0, 1]);
}

#[test]
fn one_codec_in_two_tables() {
    let text = edited("id = \"raw\"", "id = \"raw\"\n[[codec]]\nid = \"raw\"\nbits = [8, \"native\"]");
    let set = ["pipeline.site=host", "pipeline.filter=linear", "codec.s3dc.block=4"];
    let resolution = resolved(&text, &set, &Capabilities::default());
    let settings: Vec<String> = resolution.cells.iter().map(|c| c.settings.to_string()).collect();
    assert_eq!(settings, ["bits=native", "bits=8", "block=4 index_bits=2", "block=4 index_bits=4"]);
    assert_eq!(resolution.refused[0].reason, Reason::Repeated);
}

#[test]
fn a_renderer_that_this_build_lacks() {
    let registry = registry();
    let experiment = read(EXAMPLE, &[]).unwrap();
    let known = Known { renderers: &[&SLICING], ..known(&registry) };
    let resolution = resolve(&experiment, &known, &Capabilities::default());
    assert_eq!(resolution.cells, []);
    assert_eq!(resolution.refused[0].reason.to_string(), "this build has no renderer raycasting");
}

#[test]
fn scenes_for_their_volumes() {
    let text = edited(
        "[[codec]]\nid = \"raw\"",
        "[[volume]]\nname = \"b\"\ngenerate = \"shepp-logan\"\n[[codec]]\nid = \"raw\"",
    );
    let own = "[[scene]]\nname = \"own\"\nvolumes = [\"b\"]\ntransfer_function = [[0, \"#000000\"], [1, \"#ffffff\"]]\n";
    let resolution = resolved(&format!("{text}{own}"), &[], &Capabilities::default());
    let mut pairs: Vec<(&str, &str)> =
        resolution.cells.iter().map(|c| (c.volume.as_str(), c.scene.as_str())).collect();
    pairs.dedup();
    assert_eq!(pairs, [("bonsai", "front"), ("b", "own")]);
}

#[test]
fn ids_are_safe_and_distinct() {
    let template = resolved(EXAMPLE, &[], &Capabilities::default()).cells.remove(0);
    let id = |volume: &str, scene: &str| {
        Cell { volume: volume.to_owned(), scene: scene.to_owned(), ..template.clone() }.id()
    };
    let long = "x".repeat(300);
    let names =
        ["a", "a-b", "a b", "a_b", "..", "-a", "é", "ü", "a/../b", "b", long.as_str(), "a-raw-bits=native-s"];
    let mut seen = std::collections::HashSet::new();
    for volume in names {
        for scene in names {
            let id = id(volume, scene);
            assert!(id.chars().all(|c| c.is_ascii_alphanumeric() || "._=,-".contains(c)), "{id}");
            assert!(id.len() <= Cell::MAX_ID_BYTES && !id.starts_with(['.', '-']), "{id}");
            assert!(seen.insert(id.clone()), "{id} twice");
        }
    }
    assert_eq!(id("a b", "s"), "a_b-raw-bits=native-s-raycasting-inline-nearest-6763f83c");
}
