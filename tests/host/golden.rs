//! Golden pictures, drawn by the CPU mirrors and never by a device: volumes × codecs × projections × filters by
//! raycasting, and one of each kind of light, clip box and geometry of slices.

use cvr::input::Generator;
use cvr::registry::{Names, renderer};
use cvr_core::codec::{SettingValue, Settings};
use cvr_core::metrics::{shifted, visible};
use cvr_core::pipeline::parse_colour;
use cvr_core::render::{
    Camera, ControlPoint, DecodedFrame, Filter, Image, Light, Projection, TransferFunction, View,
};
use cvr_core::volume::{DenseVolume, FiniteVolume, FrameIndex, SampleType};

use super::golden_files::Goldens;
use super::scene_combinations::Optics;
use super::volumes::{computed, floats, opened, spaced};

/// One golden picture.
struct Golden {
    volume: &'static str,
    codec: &'static str,
    projection: Projection,
    filter: Filter,
    renderer: &'static str,
    optics: Optics,
}

/// Lit, clipped, and in slices.
fn of_every_kind() -> Vec<Golden> {
    use Projection::{Orthographic, Perspective};
    let golden = |volume, codec, projection, filter, renderer, lit, clipped| {
        let optics = Optics { lit, clipped, skipping: false };
        Golden { volume, codec, projection, filter, renderer, optics }
    };
    let (camera, fixed) = (Some(Light::Camera), Some(Light::Fixed));
    let (shells, axis) = ("slicing,geometry=shells", "slicing,geometry=axis");
    let (drops, turbulence, linear) = ("drops", "turbulence", Filter::Linear);
    vec![
        golden(drops, "raw", Perspective, linear, "raycasting", camera, false),
        golden(drops, "raw", Perspective, linear, "raycasting", None, true),
        golden(turbulence, "raw", Orthographic, linear, "raycasting", fixed, true),
        golden(drops, "s3dc", Perspective, linear, "slicing", camera, true),
        golden(turbulence, "raw", Orthographic, Filter::Nearest, "slicing", None, true),
        golden(turbulence, "raw", Perspective, linear, axis, camera, false),
        golden(drops, "raw", Perspective, linear, shells, fixed, false),
    ]
}

fn all() -> Vec<Golden> {
    let mut all = of_every_kind();
    for volume in ["marschner-lobb", "turbulence"] {
        for codec in ["raw", "s3dc"] {
            for projection in [Projection::Perspective, Projection::Orthographic] {
                for filter in [Filter::Nearest, Filter::Linear] {
                    let (renderer, optics) = ("raycasting", Optics::default());
                    all.push(Golden { volume, codec, projection, filter, renderer, optics });
                }
            }
        }
    }
    all
}

/// Three drops that run into each other. They are smooth, so a picture shows the direction of the light.
fn drops() -> DenseVolume {
    let drops = [([0.35, 0.4, 0.4], 0.17), ([0.65, 0.55, 0.35], 0.14), ([0.5, 0.5, 0.72], 0.12)];
    floats([40; 3], |p| {
        let x = p.map(|c| (c as f32 + 0.5) / 40.0);
        let drop = |(centre, radius): &([f32; 3], f32)| {
            let squares = x.iter().zip(centre).map(|(a, b)| (a - b) * (a - b));
            (-squares.sum::<f32>() / (2.0 * radius * radius)).exp()
        };
        drops.iter().map(drop).sum()
    })
}

impl Golden {
    fn name(&self) -> String {
        let projection = match self.projection {
            Projection::Perspective => "perspective",
            Projection::Orthographic => "orthographic",
        };
        let mut name = format!("{}-{}-{projection}-{}", self.volume, self.codec, self.filter);
        if self.renderer != "raycasting" {
            name = format!("{name}-{}", self.renderer.replace([',', '='], "-"));
        }
        let light = match self.optics.lit {
            None => "",
            Some(Light::Camera) => "-lit",
            Some(Light::Fixed) => "-lit-fixed",
        };
        format!("{name}{light}{}", if self.optics.clipped { "-clipped" } else { "" })
    }

    fn original(&self) -> DenseVolume {
        match self.volume {
            "turbulence" => {
                let volume = computed(Generator::Turbulence, [24, 32, 16], SampleType::U16);
                spaced(&volume, [1.0, 0.75, 2.0])
            }
            "drops" => drops(),
            _ => computed(Generator::MarschnerLobb, [32; 3], SampleType::U8),
        }
    }

    fn decoded(&self) -> DecodedFrame {
        let names = Names::new().unwrap();
        let codec = names.codecs().get(self.codec).unwrap();
        let settings: Settings = match self.codec {
            "s3dc" => [("block", SettingValue::Integer(4)), ("index_bits", SettingValue::Integer(2))]
                .map(|(name, value)| (name.to_owned(), value))
                .into_iter()
                .collect(),
            _ => Settings::default(),
        };
        let volume = FiniteVolume::new(self.original());
        let decoder = opened(codec.as_ref(), &settings, &volume);
        DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap()
    }

    fn view(&self) -> View {
        // Data values and colours: a surface in a haze.
        let points: &[(f32, &str)] = match self.volume {
            "turbulence" => &[
                (22000.0, "#00000000"),
                (30000.0, "#2060b010"),
                (38000.0, "#f0a040a0"),
                (65535.0, "#ffffffff"),
            ],
            "drops" => &[
                (0.0, "#80a0ff00"),
                (0.3, "#80a0ff06"),
                (0.45, "#d0d8e010"),
                (0.5, "#e8d8c0d0"),
                (2.0, "#e8d8c0ff"),
            ],
            _ => &[
                (95.0, "#2060b000"),
                (110.0, "#2060b030"),
                (128.0, "#f0a040c0"),
                (145.0, "#d0d8e040"),
                (180.0, "#ffffff00"),
            ],
        };
        let point = |(value, colour): &(f32, &str)| {
            let ([r, g, b], alpha) = parse_colour(colour).unwrap();
            ControlPoint { value: *value, rgba: [r, g, b, alpha.unwrap()] }
        };
        let view = View {
            size: [64, 64],
            camera: Camera {
                azimuth: 35.0,
                elevation: 25.0,
                projection: self.projection,
                ..Camera::default()
            },
            termination: 0.999,
            filter: self.filter,
            ..View::new(TransferFunction::new(points.iter().map(point).collect()).unwrap())
        };
        self.optics.drawn(view)
    }

    fn draw(&self, voxels: &DecodedFrame) -> Image {
        self.draw_view(&self.view(), voxels)
    }

    fn draw_view(&self, view: &View, voxels: &DecodedFrame) -> Image {
        let mut image = Image::new(view.size);
        renderer(self.renderer).unwrap().reference(view, voxels, &mut image).unwrap();
        image
    }
}

/// The volume moved by one voxel along x. The first plane stays.
fn moved(voxels: &DecodedFrame) -> DecodedFrame {
    let width = voxels.layout().extent.x() as usize;
    let value = |i: usize| voxels.values()[if i.is_multiple_of(width) { i } else { i - 1 }];
    DecodedFrame::new(voxels.layout().clone(), (0..voxels.values().len()).map(value).collect()).unwrap()
}

#[test]
fn pictures_are_those_that_were_blessed() {
    let goldens = Goldens::of_project();
    let problems: Vec<String> = all()
        .iter()
        .filter_map(|golden| goldens.check(&golden.name(), &golden.draw(&golden.decoded())).err())
        .collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Whether a picture breaks the rule. A missing golden is not a difference.
fn differs(goldens: &Goldens, name: &str, picture: &Image) -> bool {
    goldens.check(name, picture).is_err_and(|problem| problem.contains("golden picture: "))
}

/// The test of the test: an error of one pixel or one voxel gives another picture.
#[test]
fn a_shift_by_one_pixel_or_voxel_is_another_picture() {
    let folder = tempfile::tempdir().unwrap();
    let goldens = Goldens { failures: folder.path().join("failures"), bless: false, ..Goldens::of_project() };
    for golden in all() {
        let voxels = golden.decoded();
        let picture = golden.draw(&voxels);
        let name = golden.name();
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            assert!(differs(&goldens, &name, &shifted(&picture, dx, dy)), "{name}: {dx} {dy}");
        }
        assert!(differs(&goldens, &name, &golden.draw(&moved(&voxels))), "{name}: one voxel");
    }
}

/// Another light and a box that ends one voxel further give other pictures, with every renderer.
#[test]
fn another_light_or_box_is_another_picture() {
    let folder = tempfile::tempdir().unwrap();
    let goldens = Goldens { failures: folder.path().join("failures"), bless: false, ..Goldens::of_project() };
    let mut wrong = 0;
    for golden in of_every_kind() {
        let (view, voxels, name) = (golden.view(), golden.decoded(), golden.name());
        let mut differs = |what: &str, view: View| {
            wrong += 1;
            assert!(differs(&goldens, &name, &golden.draw_view(&view, &voxels)), "{name}: {what}");
        };
        if let Some(shading) = view.shading {
            for axis in 0..3 {
                let mut shading = shading;
                shading.direction[axis] = -shading.direction[axis];
                differs("light", View { shading: Some(shading), ..view.clone() });
            }
        }
        if let Some(clip) = view.clip {
            // The corner that the camera sees.
            for (axis, high) in [(1, false), (2, true)] {
                let mut clip = clip;
                let side = if high { &mut clip.high } else { &mut clip.low };
                side[axis] += 1.0 / voxels.layout().extent.to_array()[axis] as f32;
                differs("box", View { clip: Some(clip), ..view.clone() });
            }
        }
    }
    assert_eq!(wrong, 5 * 3 + 4 * 2);
}

/// Goldens that were all alike would prove little.
#[test]
fn every_golden_shows_something_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let goldens = Goldens { failures: folder.path().join("failures"), bless: false, ..Goldens::of_project() };
    let pictures: Vec<(String, Image)> = all().iter().map(|g| (g.name(), g.draw(&g.decoded()))).collect();
    for (name, picture) in &pictures {
        let seen = picture.pixels().iter().filter(|p| visible(p)).count();
        assert!((500..3800).contains(&seen), "{name}: {seen} of 4096 pixels are visible");
        for (other, _) in pictures.iter().filter(|(other, _)| other != name) {
            assert!(differs(&goldens, other, picture), "{name} passes for {other}");
        }
    }
    let files = std::fs::read_dir(&goldens.folder).unwrap().count();
    assert_eq!(files, pictures.len(), "a file in {} belongs to no test", goldens.folder.display());
}
