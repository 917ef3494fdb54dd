//! Commands that print: codecs, renderers, presets, devices, shaders, cells.

use std::process::Command;

use cvr::registry::{Names, renderers};
use cvr_core::codec::Site;
use cvr_core::pipeline::parse_colour;
use cvr_core::render::Preset;

use super::super::configs::COMPARE;
use super::super::folder::Folder;

#[test]
fn codecs_are_listed_with_all_their_settings() {
    let text = Folder::new().cvr(&["codecs"]).exits(0).stdout;
    for codec in Names::new().unwrap().codecs().iter() {
        let info = codec.info();
        assert!(text.contains(&format!("{}  {}\n", info.id, info.summary)), "{text}");
        for setting in info.settings {
            assert!(text.contains(&format!("    {} = {}\n", setting.name, setting.default)), "{text}");
            assert!(text.contains(setting.doc), "{text}");
        }
        let sites = info.offered().map(Site::name).collect::<Vec<_>>().join(", ");
        assert!(text.contains(&format!("    sites: {sites}")), "{text}");
        if let Some(paper) = &info.paper {
            assert!(text.contains(paper.title), "{text}");
        }
    }
}

#[test]
fn renderers_are_listed_with_all_their_settings() {
    let text = Folder::new().cvr(&["renderers"]).exits(0).stdout;
    for info in renderers().iter().map(|r| r.info()) {
        assert!(text.contains(&format!("{}  {}\n", info.id, info.summary)), "{text}");
        for setting in info.settings {
            assert!(text.contains(&format!("    {} = {}\n", setting.name, setting.default)), "{text}");
            assert!(text.contains(setting.doc), "{text}");
            assert!(text.contains(&setting.kind.describe()), "{text}");
        }
    }
}

/// Listed points give the same picture as the name, except for colours rounded to 8 bits.
#[test]
fn presets_are_listed_with_points_that_the_command_line_takes() {
    let folder = Folder::new();
    let text = folder.cvr(&["presets"]).exits(0).stdout;
    let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
    assert_eq!(lines.len(), 2 * Preset::ALL.len(), "{text}");
    for (preset, pair) in Preset::ALL.iter().zip(lines.chunks(2)) {
        assert_eq!(pair[0], format!("{}  {}", preset.name, preset.doc));
        let points = pair[1].trim();
        for (written, point) in points.split(',').zip(preset.control_points()) {
            let (value, colour) = written.split_once(':').unwrap();
            let ([r, g, b], a) = parse_colour(colour).unwrap();
            assert_eq!(value.parse::<f32>().unwrap(), point.value);
            let near = |(a, b): (f32, &f32)| (a - b).abs() < 0.5 / 255.0 + 1e-6;
            assert!(
                [r, g, b, a.unwrap()].into_iter().zip(&point.rgba).all(near),
                "{}: {written}",
                preset.name
            );
        }
        assert_eq!(points.matches(':').count(), preset.control_points().len(), "{points}");
        folder.cvr(&["shader", "--range", "--transfer-function", points]).exits(0);
    }
}

/// Adapters are the machine's; the mirror is always there.
#[test]
fn devices_end_with_the_mirror() {
    let ran = Folder::new().cvr(&["devices"]);
    let adapters = ran.stdout.lines().filter(|line| line.starts_with('#')).count();
    assert_eq!(ran.code, Some(i32::from(adapters == 0)), "{ran:?}");
    assert!(ran.stdout.lines().last().unwrap().starts_with("cpu  "), "{}", ran.stdout);
    assert_eq!(ran.stdout.lines().count(), adapters + 1, "{}", ran.stdout);

    // Called as `./run` and `./test` call it. The folder's own command is not used, because it refuses tabs in output
    // for people.
    let output = Command::new(env!("CARGO_BIN_EXE_cvr")).args(["devices", "--tsv"]).output().unwrap();
    let for_scripts = String::from_utf8(output.stdout).unwrap();
    assert_eq!((output.status.code(), for_scripts.lines().count()), (ran.code, adapters));
    for (i, (line, told)) in for_scripts.lines().zip(ran.stdout.lines()).enumerate() {
        let fields: Vec<&str> = line.split('\t').collect();
        let [number, backend, kind, name, _] = fields[..] else { panic!("{line}") };
        assert_eq!(number, i.to_string(), "{line}");
        assert!(told.starts_with(&format!("#{i}  {name} ({backend}, {kind}")), "{line}, {told}");
    }
}

#[test]
fn a_shader_is_printed_with_the_origin_of_every_part() {
    let folder = Folder::new();
    let inline = folder.cvr(&["shader"]).exits(0);
    let origins: Vec<&str> = inline.stdout.lines().filter(|l| l.starts_with("// ==== ")).collect();
    insta::assert_snapshot!(origins.join("\n"));
    naga::front::wgsl::parse_str(&inline.stdout).unwrap();

    let host = folder.cvr(&["shader", "--site", "host", "--orthographic"]).exits(0).stdout;
    assert!(host.contains("texture_3d") && host.contains("orthographic.wgsl") && !host.contains("s3dc"));
    assert!(host.starts_with("// Site host, on ") && host.contains("texels of single precision"), "{host}");
    let blocks = folder.cvr(&["shader", "--site", "host", "--codec", "bc4"]).exits(0).stdout;
    let told = blocks.lines().next().unwrap();
    // The blocks, or the reason: the device has no such textures, or claims them and does not decode them.
    assert!(told.contains("blocks of BC4") || told.contains("3-D textures of the codec's blocks"), "{told}");
    naga::front::wgsl::parse_str(&blocks).unwrap();
    // Two complete shaders: one decodes and contains no renderer, one draws and contains no codec.
    let deferred = folder.cvr(&["shader", "--site", "deferred"]).exits(0).stdout;
    let (decodes, draws) = deferred.split_once("// ==== next pass").unwrap();
    assert!(
        decodes.contains("fn s3dc_fetch(") && decodes.contains("texels[") && !decodes.contains("raycast")
    );
    assert!(draws.contains("texture_3d") && draws.contains("fn gather(") && !draws.contains("s3dc"));
    for pass in [decodes, draws] {
        naga::front::wgsl::parse_str(pass).unwrap();
    }
    let ring = ["shader", "--site", "ring", "--renderer", "slicing,geometry=axis"];
    let ring = folder.cvr(&ring).exits(0).stdout;
    let (decodes, draws) = ring.split_once("// ==== next pass").unwrap();
    assert!(
        decodes.contains("fn s3dc_fetch(") && decodes.contains("texels[") && !decodes.contains("slab_cr")
    );
    assert!(draws.contains("ring_layers") && draws.contains("fn shown(") && !draws.contains("s3dc"));
    for pass in [decodes, draws] {
        naga::front::wgsl::parse_str(pass).unwrap();
    }
    let lit = folder.cvr(&["shader", "--shading", "--clip-box", "0,0,0:1,1,0.5"]).exits(0).stdout;
    assert!(lit.contains("fn gradient(") && lit.contains("shaders/bounds/clip.wgsl"));
    let slices = folder.cvr(&["shader", "--renderer", "slicing,geometry=axis"]).exits(0).stdout;
    assert!(slices.contains("fn slab_crossing(") && !slices.contains("fn gradient("));
    let settings = ["shader", "--set", "block=3x5x2", "--set", "index_bits=8"];
    let other = folder.cvr(&settings).exits(0).stdout;
    assert!(other.contains("vec3<u32>(3u, 5u, 2u)") && !inline.stdout.contains("vec3<u32>(3u, 5u, 2u)"));
    for wrong in [
        &["shader", "--codec", "none"][..],
        &["shader", "--set", "block"],
        &["shader", "--renderer", "none"],
        &["shader", "--codec", "raw", "--filter", "optimised-linear"],
        &["shader", "--site", "host", "--filter", "optimised-linear"],
        &["shader", "--site", "deferred", "--filter", "optimised-linear"],
        &["shader", "--site", "ring", "--renderer", "slicing,geometry=axis", "--filter", "optimised-linear"],
        &["shader", "--site", "ring"],
        &["shader", "--site", "ring", "--renderer", "slicing"],
        &["shader", "--zoom", "0"],
        &["shader", "--transfer-function", "tisue"],
    ] {
        folder.cvr(wrong).refused();
    }
}

#[test]
fn cells_are_listed_and_nothing_runs() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE.replace("\"linear\"]", "\"optimised-linear\"]"));
    let text = folder.cvr(&["run", "x.toml", "--list-cells"]).exits(0).stdout;
    let (refused, cells): (Vec<&str>, Vec<&str>) = text.lines().partition(|l| l.starts_with("refused "));
    // nearest: 7 × 2 sites; optimised: 6 of s3dc, inline.
    assert_eq!((cells.len(), refused.len()), (20, 8), "{text}");
    let named = "bonsai-s3dc-block=8x8x4,index_bits=2-front-raycasting-inline-optimised-linear";
    assert!(cells.contains(&named), "{text}");
    let checked = folder.cvr(&["check-config", "x.toml"]).exits(0).stdout;
    assert!(checked.starts_with("x.toml: 20 cells\n") && checked.contains(refused[0]), "{checked}");
    assert_eq!(folder.names(), ["x.toml"]);
}

#[test]
fn overrides_and_volumes_change_the_cells() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let list = |more: &[&str]| {
        let arguments = [&["run", "x.toml", "--list-cells"][..], more].concat();
        folder.cvr(&arguments).exits(0).stdout
    };
    assert_eq!(list(&[]).lines().count(), 28);
    let one =
        ["--set", "codec.s3dc.block=16", "--set", "pipeline.site=host", "--set", "pipeline.filter=linear"];
    let expected = "bonsai-raw-bits=native-front-raycasting-host-linear\n\
                    bonsai-s3dc-block=16,index_bits=2-front-raycasting-host-linear\n\
                    bonsai-s3dc-block=16,index_bits=4-front-raycasting-host-linear\n";
    assert_eq!(list(&one), expected);
    let other = list(&["--volume", "some/head.nrrd"]);
    assert!(other.lines().count() == 28 && other.lines().all(|l| l.starts_with("head-")), "{other}");
}
