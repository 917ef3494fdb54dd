//! The origin of a colour's opacity, from a configuration to pictures and figures.

use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::Record;
use cvr::input::write_npy;
use cvr_core::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "colours"
[[volume]]
name = "dyes"
file = "dyes.nrrd"
[[codec]]
id = "s3dc"
block = 4
[pipeline]
renderer = ["raycasting", "slicing"]
site = ["inline", "host"]
filter = "linear"
"##;

/// A cube of red next to green, both increasing, with a little blue noise.
fn dyes() -> DenseVolume {
    let extent = Extent::cube(12).unwrap();
    let layout = VolumeLayout { channels: 3, ..VolumeLayout::scalar(extent, SampleType::U8) };
    let voxel = |i: u32| {
        let (x, y) = ((i % 12) as u8, (i / 12 % 12) as u8);
        let blue = (i.wrapping_mul(0x9e37_79b9) >> 26) as u8;
        if x < 6 { [7 * x * x, 10, blue] } else { [0, 2 * y * y, blue] }
    };
    DenseVolume::new(layout, Samples::U8((0..12 * 12 * 12).flat_map(voxel).collect())).unwrap()
}

/// Opacities of one channel.
fn table(edge: u32, of: impl Fn([u32; 3]) -> f32) -> DenseVolume {
    let extent = Extent::cube(edge).unwrap();
    let entry = |i: u32| of([i % edge, i / edge % edge, i / edge / edge]);
    let samples = Samples::F32((0..edge.pow(3)).map(entry).collect());
    DenseVolume::new(VolumeLayout::scalar(extent, SampleType::F32), samples).unwrap()
}

/// The file of the table.
fn with_tables() -> Folder {
    let folder = Folder::new();
    folder.volume("dyes.nrrd", &dyes());
    write_npy(&folder.path("red.npy"), &table(2, |[r, ..]| 0.5 * r as f32)).unwrap();
    folder
}

fn run(folder: &Folder, scenes: &[(&str, &str)]) -> Vec<Record> {
    let scene = |(name, opacity): &(&str, &str)| {
        format!(
            "[[scene]]\nname = \"{name}\"\n{opacity}\nsize = [30, 30]\ntransfer_function_domain = \"range\"\n\
             transfer_function = [[0, \"#ffffff00\"], [1, \"#ffffff80\"]]\n"
        )
    };
    let text = CONFIG.to_owned() + &scenes.iter().map(scene).collect::<String>();
    folder.write("colours.toml", text);
    folder.cvr(&["run", "colours.toml", "--device", "cpu", "--out", "out"]).exits(0);
    Results::read(&folder.path("out/results.json")).unwrap().records
}

#[test]
fn each_way_to_decide_draws_another_picture_and_channels_have_figures_of_their_own() {
    let folder = with_tables();
    let opacities = [
        ("none", ""),
        ("luminance", "opacity = \"luminance\""),
        ("red", "opacity = \"red\""),
        ("green", "opacity = \"green\""),
        ("blue", "opacity = \"blue\""),
        ("table", "opacity = { table = \"red.npy\" }"),
    ];
    let records = run(&folder, &opacities);
    assert_eq!(records.len(), 6 * 4);
    for renderer in ["raycasting", "slicing"] {
        let picture = |scene: &str| {
            let of = |r: &&Record| r.scene == scene && r.renderer == renderer && r.site == "host";
            folder.read(&format!("out/{}", records.iter().find(of).unwrap().image.as_ref().unwrap()))
        };
        assert!(picture("none") == picture("luminance"), "luminance unless a scene says otherwise");
        let different = ["luminance", "red", "green", "blue"];
        for (i, one) in different.iter().enumerate() {
            for other in &different[i + 1..] {
                assert!(picture(one) != picture(other), "{renderer}: {one} as {other}");
            }
        }
        assert!(picture("table") != picture("green"));
    }
    for record in &records {
        let channels = [record.psnr_red_db, record.psnr_green_db, record.psnr_blue_db].map(Option::unwrap);
        assert_ne!(channels[0], channels[1]);
        let mse = channels.iter().map(|psnr| 10_f64.powf(-psnr / 10.0)).sum::<f64>() / 3.0;
        assert!((-10.0 * mse.log10() - record.psnr_db.unwrap()).abs() < 1e-9);
    }
    let csv = folder.text("out/results.csv");
    assert!(csv.lines().next().unwrap().contains(",psnr_red_db,psnr_green_db,psnr_blue_db,"));
}

/// A table that equals the channel gives the channel's picture; a rotated one does not.
#[test]
fn a_table_runs_red_along_x() {
    let folder = with_tables();
    write_npy(&folder.path("blue.npy"), &table(2, |[.., b]| 0.5 * b as f32)).unwrap();
    let draw = |opacity: &str, out: &str| {
        let function = "0:#ffffff00,255:#ffffff80";
        let args = ["render", "dyes.nrrd", out, "--size", "40x40", "--device", "cpu", "--opacity", opacity];
        folder.cvr(&[&args[..], &["--transfer-function", function]].concat()).exits(0);
        let picture = image::open(folder.path(out)).unwrap().to_rgb8();
        picture.pixels().map(|p| p.0.map(f64::from)).collect::<Vec<_>>()
    };
    let difference = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        let all = a.iter().flatten().zip(b.iter().flatten());
        all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (channel, table, turned) =
        (draw("red", "a.png"), draw("red.npy", "b.png"), draw("blue.npy", "c.png"));
    // 0x80 of the function's end is 128/255, and the table's a half.
    assert!(difference(&channel, &table) <= 2.0, "{}", difference(&channel, &table));
    assert!(difference(&channel, &turned) > 20.0);
}

#[test]
fn what_is_no_table_is_refused_with_its_file() {
    let folder = with_tables();
    write_npy(&folder.path("bright.npy"), &table(2, |_| 1.5)).unwrap();
    write_npy(&folder.path("one.npy"), &table(1, |_| 1.0)).unwrap();
    let slab = VolumeLayout::scalar(Extent::new(2, 2, 3).unwrap(), SampleType::F32);
    write_npy(&folder.path("slab.npy"), &DenseVolume::new(slab, Samples::F32(vec![0.0; 12])).unwrap())
        .unwrap();
    for (file, expected) in [
        ("bright.npy", "entry 0 of the opacity table is 1.5: opacities run from 0 to 1"),
        ("one.npy", "cube of 2 to 64 entries along each of red, green and blue; this has [1, 1, 1]"),
        ("slab.npy", "this has [2, 2, 3]"),
        ("dyes.nrrd", "this has [12, 12, 12, 3]"),
        ("none.npy", "none.npy"),
    ] {
        let scene = "[[scene]]\nname = \"s\"\ntransfer_function = \"ramp\"\n";
        folder.write("a.toml", format!("{CONFIG}{scene}opacity = {{ table = \"{file}\" }}\n"));
        let refused = folder.cvr(&["run", "a.toml", "--device", "cpu"]).refused();
        assert!(refused.contains("scene `s`") && refused.contains(expected), "{refused}");
        let refused =
            folder.cvr(&["render", "dyes.nrrd", "a.png", "--opacity", file, "--device", "cpu"]).refused();
        assert!(refused.contains(expected), "{refused}");
    }
    folder.write("a.toml", format!("{CONFIG}[[scene]]\nname = \"s\"\ntransfer_function = \"ramp\"\nopacity = {{ table = \"$CVR_NO_SUCH/a.npy\" }}\n"));
    let refused = folder.cvr(&["run", "a.toml", "--device", "cpu"]).refused();
    assert!(refused.contains("CVR_NO_SUCH"), "{refused}");
    assert!(!folder.names().iter().any(|n| n.starts_with("results")), "bad input leaves nothing behind");
}
